"""Does a signature show what an effect does to a record: where it must, by as much as it must, and nothing where it is neutral?"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat import signature as signed_effects
from evat import units
from evat.model import Effect, ParameterError
from evat.native import kernel
from evat.native.compile import PACKAGE
from evat.plots.signature import plot_signature
from evat.signature import Signature, SignaturePanel, effect_named, signature
from evat.signature.runs import Case

EFFECTS = {effect.name: effect for effect in kernel.effects()}
FILES = (
    "signature/__init__.py",
    "signature/runs.py",
    "signature/conditions.py",
    "plots/signature.py",
    "commands/effects.py",
    "required_inputs.py",
)


FIRST = {effect.family or effect.name: effect.name for effect in reversed(EFFECTS.values())}  # of each family, in each run
FIRST["lag"] = "dynamometer_resonance"  # the holder's, which is first, takes ten seconds
NEUTRAL = ("amplitude_loss", "cross_talk", "direction_asymmetry")
EACH = pytest.mark.parametrize(
    "effect",
    [pytest.param(effect, id=name, marks=() if name in FIRST.values() else pytest.mark.campaign) for name, effect in EFFECTS.items()],
)


@pytest.fixture(autouse=True, scope="module")
def runs_without_are_kept() -> Iterator[None]:
    """Runs without any effect are the same for all of them: what an effect owns does not act where it is off (test_catalogue.py)."""
    own = {variable.name for effect in EFFECTS.values() for variable in effect.variables}

    def kept(answers: Callable[[Case], Any]) -> Callable[[Case], Any]:
        known: dict[tuple[tuple[str, float], ...], Any] = {}

        def answer(case: Case) -> Any:
            if any(case.values.get(name) for name in EFFECTS):
                return answers(case)
            key = tuple(sorted((name, value) for name, value in case.values.items() if name not in own and name not in EFFECTS))
            if key not in known:
                known[key] = answers(case)
            return known[key]

        return answer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signed_effects, "CONDITIONS", [replace(each, answers=kept(each.answers)) for each in signed_effects.CONDITIONS])
        for name in ("one_cycle", "to_and_fro"):
            patch.setattr(signed_effects, name, kept(getattr(signed_effects, name)))
        yield


def over(signed: Signature, across: str, title: str = "") -> SignaturePanel:
    """The panel of a condition, by what is varied."""
    (panel,) = (panel for panel in signed.conditions if panel.across.name == across and title in panel.title)
    return panel


@EACH
def test_every_effect_shows_somewhere_and_its_panels_have_units(effect: Effect) -> None:
    signed = signature(effect.name)
    panels = (*signed.cycle, signed.rig, *signed.conditions)
    assert any(panel.shows for panel in panels)
    assert max(panel.share for panel in panels[:4]) > 1e-3 or signed.conditions[0].share > 0.01  # it can be seen in the picture
    for panel in panels:
        for axis in (panel.across, panel.up):
            assert units.affine(axis.unit, axis.display_unit)[0] > 0
        assert panel.without.shape == panel.with_effect.shape == panel.over[0].shape == panel.over[1].shape
        assert np.all(np.isfinite([*panel.without, *panel.with_effect]))
    ranks = [(not panel.varies, -panel.share) for panel in signed.conditions]
    assert ranks == sorted(ranks)
    assert len({(panel.title, panel.across.name) for panel in signed.conditions}) == len(signed.conditions)
    assert signed.left_out == ()


# That neutral is off to the last bit is seen of every effect in test_catalogue.py: in each run one with states and one without.
@pytest.mark.parametrize(
    "effect",
    [pytest.param(effect, id=name, marks=() if name in NEUTRAL else pytest.mark.campaign) for name, effect in EFFECTS.items()],
)
def test_a_neutral_effect_shows_nowhere(effect: Effect) -> None:
    neutral = {variable.name: variable.neutral for variable in effect.variables if math.isfinite(variable.neutral)}
    signed = signature(effect.name, neutral)
    # the tolerance of the runs: with states, the periodic start is found by another method
    assert max(panel.share for panel in (*signed.cycle, signed.rig, *signed.conditions)) < 1e-5
    assert signed.left_out == ()


def test_no_effect_is_named_in_the_code() -> None:
    text = "".join((PACKAGE / name).read_text(encoding="utf-8") for name in FILES).replace("evat effects run_out -v run_out.amplitude", "")
    text = text.replace("-o run-out.png", "")
    assert [name for name in EFFECTS if name in text] == []


def test_a_gain_is_one_factor_everywhere() -> None:
    values = {f"sensor_gain.{name}": 1.25 for name in ("friction_force", "principal_force", "feed_force")}
    signed = signature("sensor_gain", values)
    for panel in (*signed.cycle[:3], signed.rig, *signed.conditions):
        if "contact" not in panel.up.name:
            assert panel.with_effect == pytest.approx(1.25 * panel.without, rel=1e-9, abs=1e-12)
            assert panel.share == pytest.approx(0.2, rel=1e-9)  # 0.25 of 1.25


def test_an_offset_is_there_where_nothing_touches() -> None:
    signed = signature("sensor_offset", {"sensor_offset.feed_force": 3.0})
    _, _, feed, _ = signed.cycle
    assert feed.with_effect - feed.without == pytest.approx(np.full(feed.without.size, 3.0), abs=1e-9)
    assert np.any(feed.without == 0)


def test_run_out_is_a_line_at_the_spindle_frequency_in_the_long_record() -> None:
    signed = signature("run_out", {"run_out.spindle_frequency": 25.0})
    assert [panel.across.name for panel in signed.conditions[:2]] == ["time", "time"]
    panel = over(signed, "time", "later")
    step = panel.over[0][1] - panel.over[0][0]
    assert panel.over[0].size * step == pytest.approx(0.2)  # 5 turns
    spectrum = np.abs(np.fft.rfft(panel.with_effect - panel.without))
    lines = np.fft.rfftfreq(panel.over[0].size, step)
    assert lines[np.argmax(spectrum)] == pytest.approx(25)
    assert np.sort(spectrum)[-2] < 0.02 * spectrum.max()  # the force is all but linear in the thickness


def test_a_carried_tool_meets_its_own_surface_after_one_turn() -> None:
    """Six and a half waves in 0.2 s: with a turn of two of them the surface goes with the tool, and the cut stays as thick as nominal."""
    turn = 2 * 0.2 / 6.5
    signed = signature("regenerative", {"regenerative.revolution_time": turn})
    panel = over(signed, "time", "carried")
    assert signed.conditions[0] is panel
    before, after = panel.over[0] < turn, panel.over[0] > turn + 2e-3  # less two windows that hold the change
    assert panel.with_effect[before] == pytest.approx(panel.without[before], rel=1e-4)
    assert np.ptp(panel.without[after]) > 0.15 * panel.without.mean()
    assert np.ptp(panel.with_effect[after]) < 0.01 * panel.without.mean()  # the surface is kept in some 200 places of a turn


def test_edge_force_is_the_same_step_at_every_thickness() -> None:
    signed = signature("edge_force", {"edge_force.K_ef": 0.0})
    panel = over(signed, "uncut_thickness")
    assert panel.up.name == "measured_principal_force"
    width = kernel.variable("width").start
    added = np.full(panel.without.size, kernel.variable("edge_force.K_ep").start * width)
    assert panel.with_effect - panel.without == pytest.approx(added, rel=1e-9)


def test_dwell_strengthening_climbs_by_equal_steps_for_equal_ratios_of_rest() -> None:
    panel = over(signature("dwell_strengthening", {"dwell_strengthening.D_c": 1e-4}), "time at rest")
    rest, rise = panel.over[0], panel.with_effect - panel.without
    peaks = [float(np.interp(math.log(t), np.log(rest), rise)) for t in (1, math.sqrt(10), 10)]
    steps = [b - a for a, b in pairwise(peaks)]
    assert steps[1] > 0.1
    # the age from before the rest, D_c/v = 0.1 s, still counts: ln(3.26/1.1) before ln(10.1/3.26)
    assert steps[0] / steps[1] == pytest.approx(math.log(3.262 / 1.1) / math.log(10.1 / 3.262), rel=0.02)


def test_direction_asymmetry_shifts_the_loop_on_the_rig() -> None:
    """The mean of the two branches in the middle of the slip: a F_C of each branch, up and down alike."""
    signed = signature("direction_asymmetry", {"direction_asymmetry.a": 0.1})
    assert signed.rig.up.name == "measured_friction_force"
    middle = np.argsort(np.abs(signed.rig.over[0]))[:3]
    shift = signed.rig.with_effect[middle] - signed.rig.without[middle]
    assert shift == pytest.approx(0.1 * kernel.variable("F_C").start, rel=0.02)


def test_an_effect_on_the_temperature_alone_is_shown_by_the_temperature() -> None:
    signed = signature("proxy_lag")
    assert signed.rig.up.name == "theta_used"
    warm = signature("proxy_lag", {"thermal_viscosity.beta": 0.5, "sigma2": 5.0}, ["thermal_viscosity"])
    assert warm.rig.up.name != "theta_used"  # now a force shows it
    assert warm.beside == ("thermal_viscosity",)


def test_rivals_that_are_on_make_room() -> None:
    rival = EFFECTS["edge_force"].rivals[0]
    signed = signature("edge_force", {rival: 1.0}, [rival])
    assert signed.beside == ()


@pytest.mark.parametrize(
    ("name", "values", "what"),
    [
        ("run_ot", {}, "did you mean run_out"),
        ("xyzzy", {}, "`evat effects`"),
        ("run_out", {"run_out.amplitude": -1.0}, "allowed is"),
        ("run_out", {"run_out.amplitud": 1.0}, "did you mean run_out.amplitude"),
        ("thermal_viscosity", {"proxy_source": "contact_temperature"}, "needs the input contact_temperature"),
    ],
)
def test_what_cannot_be_shown_is_refused(name: str, values: Mapping[str, float | str], what: str) -> None:
    with pytest.raises(ParameterError, match=what):
        signature(name, values)


def test_a_condition_that_cannot_be_run_is_named() -> None:
    """Bristles so soft that they yield after 10 m: at 20 kHz the slip would be faster than any that the component takes."""
    signed = signature("sensor_gain", {"sigma0": 1.0})
    assert [line for line in signed.left_out if line.startswith("rig, slip to and fro, over frequency of the slip: slip_velocity = ")]
    assert "frequency of the slip" not in {panel.across.name for panel in signed.conditions}


def test_the_picture_is_the_same_bytes_each_time(tmp_path: Path) -> None:
    one, other = (plot_signature(signature("cross_talk"), tmp_path / f"{n}.png") for n in range(2))
    assert one.read_bytes() == other.read_bytes()
    assert one.stat().st_size > 10_000


def test_nearest_names_first() -> None:
    assert effect_named("stribeck").name == "stribeck"
    with pytest.raises(ParameterError, match="did you mean sensor_delay"):
        effect_named("sensr_dlay")
