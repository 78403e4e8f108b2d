"""Does every effect of the catalogue keep the promises that all effects make? One conformance test over all of them.

New effects are found by asking the kernel; nothing here names one, beside the list of those that must exist.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from evat import units
from evat.model import Effect, SimulationError
from evat.native import kernel
from evat.native.compile import source_root
from evat.native.kernel import Contact

PERIOD = 5e-5  # [s], of the vibration at its start value
EFFECTS = {effect.name: effect for effect in kernel.effects()}
# fmt: off
CONTRACT = (
    "holder_compliance", "amplitude_loss", "ellipse_phase_error", "run_out", "size_effect", "flow_stress_softening", "edge_force",
    "flank_wear", "process_damping", "thermal_softening", "thermal_damping", "thermal_viscosity", "direction_asymmetry",
    "load_dependence", "viscous_friction", "stribeck", "elasto_plastic", "dwell_strengthening", "friction_wear", "proxy_lag",
    "sensor_delay", "sensor_gain", "sensor_offset", "sensor_drift", "cross_talk", "sensor_lowpass", "dynamometer_resonance",
    "line_disturbance", "rate_and_state", "maxwell_slip", "position_dependence", "backlash", "input_delay", "sticking_limit",
    "kienzle_force",
)
# fmt: on
MOTIONS: dict[str, dict[str, float | str]] = {
    "internal": {"cutting_speed": 0.2},
    "external": {"kinematics": "external"},
    "combined": {"kinematics": "combined", "cutting_speed": 0.2, "tool_velocity_y": 0.01, "release_time": 1e-5},
}

every_effect = pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
every_motion = pytest.mark.parametrize("motion", MOTIONS)


def begun(motion: str, on: tuple[str, ...] = (), **values: float | str) -> Contact:
    contact = Contact({"sigma1": 5.0, **MOTIONS[motion], **values}, on)
    contact.start()
    return contact


def course(contact: Contact, count: int = 40, step: float = 7e-6) -> np.ndarray:
    """All variables after each step, while slip, thickness, load and temperature change (where they are inputs that count)."""
    rows = []
    for n in range(count):
        contact.set("slip_velocity", 0.1 * math.cos(0.3 * n))
        contact.set("uncut_thickness", 1e-4 * (1 - 2 * (n % 10 == 9)))
        contact.set("normal_load", 10 + 5 * math.sin(0.2 * n))
        contact.advance(step)
        rows.append(contact.values())
    return np.array(rows)


def own_places(effects: tuple[Effect, ...]) -> list[int]:
    """Places of switches and parameters of the effects: what is different on purpose."""
    return [kernel.variable(name).index for effect in effects for name in (effect.name, *(v.name for v in effect.variables))]


def test_the_catalogue_of_the_contract_is_complete() -> None:
    assert set(CONTRACT) <= set(EFFECTS)


def test_an_effect_is_listed_if_its_file_exists() -> None:
    assert {path.stem for path in (source_root() / "kernel" / "effects").glob("*.c")} == set(EFFECTS)


@every_effect
def test_the_table_tells_all(effect: Effect) -> None:
    switch = kernel.variable(effect.name)
    assert (switch.type, switch.variability, switch.start) == ("boolean", "fixed", 0)
    assert effect.equation
    assert effect.signature
    assert effect.stage
    assert effect.variables
    for variable in (switch, *effect.variables, *effect.states):
        units.parse(variable.unit)
        assert variable.meaning
        assert variable.source
        assert variable.min <= variable.start <= variable.max
    for variable in effect.variables:
        assert variable.name.startswith(f"{effect.name}.")
        assert variable.variability == "tunable"
        assert math.isfinite(variable.min)
        assert math.isfinite(variable.max)
        assert variable.min < variable.max
        assert math.isnan(variable.neutral) or variable.min <= variable.neutral <= variable.max
        assert variable.prior_sd == 0 or (variable.prior_sd > 0 and math.isfinite(variable.neutral))
    assert any(math.isfinite(variable.neutral) for variable in effect.variables)
    assert any(variable.start != variable.neutral for variable in effect.variables if math.isfinite(variable.neutral))  # on is not off
    assert all(rival in EFFECTS and effect.name in EFFECTS[rival].rivals for rival in effect.rivals)
    assert all(case in EFFECTS and effect.name not in EFFECTS[case].special_cases for case in effect.special_cases)
    assert all(kernel.variable(need).causality == "input" for need in effect.needs)
    assert len(set(effect.applies_to)) == len(effect.applies_to)
    assert effect.family.isalpha()
    inputs = set(effect.applies_to) - set(kernel.variable("kinematics").choices)
    assert all(kernel.variable(name).causality == "input" for name in inputs)


@every_motion
@every_effect
def test_neutral_is_off_to_the_last_bit(effect: Effect, motion: str) -> None:
    neutral = {variable.name: variable.neutral for variable in effect.variables if math.isfinite(variable.neutral)}
    off, on = course(begun(motion)), course(begun(motion, (effect.name,), **neutral))
    own = own_places((effect,)) + [variable.index for variable in effect.states]
    own += [v.index for v in kernel.variables() if v.derivative_of in {state.name for state in effect.states}]
    rest = np.setdiff1d(np.arange(off.shape[1]), own)
    assert np.array_equal(off[:, rest], on[:, rest])


@every_effect
def test_on_is_not_off(effect: Effect) -> None:
    """At its starting values each effect shows in some output, in one motion at least: over some cycles, or over turns of uneven work."""
    shown = [kernel.variable(name).index for name in kernel.outputs() if name not in ("step_count", "clamped_count")]
    changed = [np.max(np.abs(course(begun(motion, (effect.name,))) - course(begun(motion)))[:, shown]) for motion in MOTIONS]
    uneven = ("run_out",) if effect.name != "run_out" else ()
    turns = [course(begun("external", on), step=7e-3) for on in (uneven, (*uneven, effect.name))]
    assert max(*changed, np.max(np.abs(turns[1] - turns[0])[:, shown])) > 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_the_order_of_switching_does_not_matter(seed: int) -> None:
    luck = np.random.default_rng(seed)
    on = tuple(luck.choice(CONTRACT, 5, replace=False))
    while any(rival in on for name in on for rival in EFFECTS[name].rivals):
        on = tuple(luck.choice(CONTRACT, 5, replace=False))
    motion = list(MOTIONS)[seed % 3]
    first, second = course(begun(motion, on)), course(begun(motion, tuple(luck.permutation(on))))
    assert np.array_equal(first, second)


@every_motion
@every_effect
def test_corners_of_the_bounds_stay_finite(effect: Effect, motion: str) -> None:
    """Every corner of the parameters' box: the run goes on, with finite numbers."""
    corners = itertools.product(*((variable.min, variable.max) for variable in effect.variables))
    for corner in corners:
        values = dict(zip((variable.name for variable in effect.variables), corner, strict=True))
        contact = Contact({**MOTIONS[motion], **values}, (effect.name,))
        contact.start()
        try:
            rows = course(contact, 8)
        except SimulationError as error:  # what only a record can give
            if "follow a record" not in str(error):
                raise
            contact.run(np.arange(9) * 7e-6, {"slip_velocity": 0.1 * np.cos(0.3 * np.arange(9))}, ("friction_force",))
            rows = contact.values()[None]
        assert np.all(np.isfinite(rows[:, [kernel.variable(name).index for name in kernel.outputs()]])), values


@every_effect
def test_states_return_to_rest(effect: Effect) -> None:
    """A contact that has worked and is then left alone forgets what its states held."""
    contact = begun("external", (effect.name,))
    course(contact, 33)
    worked = [abs(contact.get(state.name)) for state in effect.states]
    contact.set("slip_velocity", 0.0)
    contact.set("uncut_thickness", -1e-4)
    for _ in range(50):
        contact.advance(1e-3)
    for state, before in zip(effect.states, worked, strict=True):
        assert abs(contact.get(state.name)) <= 1e-6 * max(before, state.nominal), state.name


@every_effect
def test_a_state_taken_in_mid_cycle_goes_on_to_the_last_bit(effect: Effect) -> None:
    contact = begun("internal", (effect.name,))
    course(contact, 5)
    twin = contact.copy()
    assert np.array_equal(course(contact, 15), course(twin, 15))


@every_effect
def test_a_periodic_start_is_periodic(effect: Effect) -> None:
    """With states of its own too: after one cycle all come back. What grows with time, turns with the spindle or is a position can not."""
    contact = Contact({"initial_state": "periodic", "cutting_speed": 0.2, "relative_tolerance": 1e-6, "sigma1": 5.0}, (effect.name,))
    contact.start()
    names = ["bristle_deflection", *(state.name for state in effect.states if not state.name.endswith(".position"))]
    before = [contact.get(name) for name in names]
    contact.advance(PERIOD)
    after = [contact.get(name) for name in names]
    scale = [max(abs(value), 1e-3 * kernel.variable(name).nominal) for name, value in zip(names, before, strict=True)]
    assert not any("periodic" in warning for warning in contact.warnings())
    assert np.max(np.abs(np.subtract(after, before)) / scale) < 1e-5


@every_effect
def test_a_mean_tells_of_an_effect_as_long_as_that_is_steady(effect: Effect) -> None:
    """The mean of the first cycle is that of a later one, but under what goes by the time or the way."""
    if not effect.applies("internal"):
        pytest.skip(f"{effect.name} happens with {', '.join(effect.applies_to)}")
    names, later = ("mean_principal_force", "mean_measured_principal_force"), 5003
    contact = Contact({"initial_state": "periodic", "cutting_speed": 0.2, "relative_tolerance": 3e-6, "sigma1": 5.0}, (effect.name,))
    contact.start()
    contact.advance(PERIOD)
    first = [contact.get(name) for name in names]
    contact.advance(later * PERIOD)
    apart = np.max(np.abs([contact.get(name) - before for name, before in zip(names, first, strict=True)]) / np.abs(first))
    assert (apart > 1e-5) == effect.unsteady, apart


@pytest.mark.parametrize(
    "effect", [each for each in EFFECTS.values() if each.stage == "measurement" and not each.unsteady], ids=lambda each: each.name
)
def test_of_what_a_sensor_does_a_filter_or_a_delay_keeps_means(effect: Effect) -> None:
    names = ("mean_measured_principal_force", "mean_measured_feed_force")
    means = list[list[float]]()
    for on in ((), (effect.name,)):
        contact = Contact({"initial_state": "periodic", "cutting_speed": 0.2, "relative_tolerance": 3e-6, "sigma1": 5.0}, on)
        contact.start()
        contact.advance(100 * PERIOD)
        means.append([contact.get(name) for name in names])
    apart = np.max(np.abs(np.subtract(*means)) / np.abs(means[0]))
    assert (apart < 1e-4) == effect.keeps_mean, apart


def test_rivals_together_are_refused() -> None:
    rivals = [(effect.name, rival) for effect in EFFECTS.values() for rival in effect.rivals]
    assert rivals
    for pair in rivals:
        one, other = pair
        with pytest.raises(SimulationError, match=rf"rivals of each other: .* \(({one} and {other}|{other} and {one})\)"):
            Contact({}, pair).start()


def test_what_is_irreversible_grows_with_the_way() -> None:
    """Wear, and nothing that a turn of the spindle or a warm-up brings back."""
    assert {each.name for each in EFFECTS.values() if each.irreversible} == {
        each.name for each in EFFECTS.values() if each.family == "wear"
    }
    assert all(each.unsteady for each in EFFECTS.values() if each.irreversible)
