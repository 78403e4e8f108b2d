"""Does a long step that jumps over cycles which repeat one another end where it would have ended through all of them?"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from evat.native import kernel
from evat.native.kernel import Contact

sys.path.insert(0, str(Path(__file__).parents[1] / "tolerance"))

from draws import VIBRATING, draw

PERIOD = 1 / 20e3  # s
FORCES = ("friction_force", "principal_force", "feed_force", "measured_friction_force", "measured_principal_force", "measured_feed_force")
IMPULSES = ("friction_impulse", "principal_impulse", "feed_impulse", "normal_impulse", "measured_feed_impulse")
GROWING = ("sliding_distance", "shear_energy", "contact_time")
MEANS = tuple(f"mean_{name}" for name in FORCES)
SHORT = 4  # cycles: a step that is looked at for none
Values = Mapping[str, float | str]


def ended(values: Values, on: tuple[str, ...], cycles: float, *, at_once: bool, inputs: Mapping[str, float] | None = None) -> Contact:
    """After so many cycles, in one step or in short ones."""
    contact = Contact(values, on)
    for name, value in (inputs or {}).items():
        contact.set(name, value)
    contact.start()
    period = 1 / contact.get("vibration_frequency")
    if at_once:
        contact.advance(cycles * period)
        return contact
    while cycles * period - contact.time > 1e-9 * period:
        contact.advance(min(SHORT * period, cycles * period - contact.time))
    return contact


def apart(one: Contact, other: Contact, cycles: float) -> float:
    """Largest difference, in tolerances of the larger of a value and the friction level."""
    level = max(one.get("F_C"), one.get("F_S"))
    time = cycles / one.get("vibration_frequency")
    sizes = {**dict.fromkeys((*FORCES, *MEANS), level), **dict.fromkeys(IMPULSES, level * time), **dict.fromkeys(GROWING, 1e-300)}
    off = [abs(one.get(name) - other.get(name)) / max(abs(other.get(name)), size) for name, size in sizes.items()]
    return max(off) / one.get("relative_tolerance")


def test_random_contacts_end_where_all_cycles_lead() -> None:
    """Over laws, effects and sources of motion. What two ways through the same cycles may differ by is the error of both, a few
    tolerances; a jump that is taken too early leaves hundreds."""
    luck = np.random.default_rng(5)
    off, saved = [], []
    for number in range(500):
        case = draw(31415, number)
        if case.kind not in VIBRATING or case.values["friction_law"] in ("bristle", "reset_integrator"):
            continue
        cycles = float(luck.choice([9, 17, 40, 150])) + float(luck.uniform(0.1, 0.9))
        values = {**case.values, "relative_tolerance": case.relative_tolerance}
        try:
            jumped, all_of_them = (ended(values, case.on, cycles, at_once=at_once) for at_once in (True, False))
        except kernel.SimulationError:
            continue  # both refuse what has no end
        off.append(apart(jumped, all_of_them, cycles))
        saved.append(jumped.get("step_count") < 0.7 * all_of_them.get("step_count"))
    assert len(off) > 100
    assert np.mean(saved) > 0.4
    assert np.quantile(off, 0.95) < 1
    assert max(off) < 10


@pytest.mark.parametrize("at_start", ["at_rest", "periodic"])
def test_as_many_cycles_as_one_likes_cost_some(at_start: str) -> None:
    values = {"initial_state": at_start, "shear_stress": 2e8}
    few, many = ended(values, (), 9, at_once=True), ended(values, (), 20_000, at_once=True)
    assert many.get("step_count") == few.get("step_count")
    assert many.get("dissipated_energy") == pytest.approx(
        20_000 / 9 * few.get("dissipated_energy"), rel=2e-1 if at_start == "at_rest" else 1e-4
    )
    assert many.time == pytest.approx(1.0, rel=1e-15)


def test_the_window_that_ends_last_has_its_mean() -> None:
    """One of its own length, which ends within the cycles that would be skipped, and one that ends with the step."""
    for window in (7.3e-4, 4.5e-3):
        one, other = (ended({"averaging_window": window}, (), 90, at_once=at_once) for at_once in (True, False))
        assert [one.get(name) for name in MEANS] == pytest.approx([other.get(name) for name in MEANS], rel=1e-4)
        assert (one.get("step_count") < 0.5 * other.get("step_count")) == (window > 4e-3)


def steps_of(values: Values, on: tuple[str, ...]) -> float:
    """Of 60 cycles at once, over those of as many one by one."""
    counts = [ended(values, on, 60, at_once=at_once).get("step_count") for at_once in (True, False)]
    return counts[0] / counts[1]


@pytest.mark.parametrize("effect", ["thermal_softening", "sensor_lowpass", "amplitude_loss", "elasto_plastic", "backlash"])
def test_what_repeats_itself_is_run_once(effect: str) -> None:
    assert steps_of({"initial_state": "periodic"}, (effect,)) < 0.2


@pytest.mark.parametrize(
    "effect", [effect.name for effect in kernel.effects() if effect.unsteady] + ["position_dependence", "regenerative", "sensor_delay"]
)
def test_what_goes_by_the_time_or_looks_back_is_run_as_it_is(effect: str) -> None:
    assert steps_of({}, (effect,)) > 0.9


@pytest.mark.parametrize("law", ["bristle", "reset_integrator"])
def test_events_of_a_law_are_run_as_they_are(law: str) -> None:
    assert steps_of({"friction_law": law, "sigma0": 2e5}, ()) > 0.9


def test_a_host_that_asks_for_events_gets_the_first() -> None:
    contact = Contact()
    contact.start()
    assert contact.advance(60 * PERIOD, stop_at_events=True) < PERIOD


def test_a_rising_input_is_followed() -> None:
    """So slowly that cycles are alike to a millionth, by 0.8 % over all of them; a law without bristles has no state that shows it."""
    contacts = []
    for steps in (1, 1000):
        contact = Contact({"kinematics": "combined", "cutting_speed": 0.1, "friction_law": "coulomb"})
        contact.start()
        contact._contact.slope[kernel.variable("cutting_speed").index - kernel.library()[1].INPUT_FIRST][0] = 0.004
        for _ in range(steps):
            contact.advance(4000 / steps * PERIOD)
        contacts.append(contact)
    assert contacts[0].get("cutting_speed") == pytest.approx(0.1008)
    assert apart(*contacts, 4000) < 1


def test_a_slow_settling_is_followed() -> None:
    """A sensor that forgets over 300 000 cycles hardly moves from one to the next, and has not settled."""
    values = {"sensor_lowpass.time_constant": 3e5 * PERIOD, "initial_state": "at_rest"}
    one, other = (ended(values, ("sensor_lowpass",), 4000, at_once=at_once) for at_once in (True, False))
    assert abs(one.get("measured_principal_force")) < 0.02 * abs(one.get("mean_principal_force"))
    assert one.get("measured_principal_force") == pytest.approx(other.get("measured_principal_force"), rel=1e-4)


@pytest.mark.parametrize("step", [1e7, 1e9])
def test_a_step_of_more_cycles_than_its_roundings_hold_apart_ends_in_time(step: float) -> None:
    """A millionth of a millionth of 2e13 cycles is twenty of them."""
    contact = Contact({"shear_stress": 2e8})
    contact.start()
    contact.advance(step)
    assert contact.time == step
