"""Is an FMU that shows a part of the contact the contact for all that it shows, and does every file have a token of its own?"""

from __future__ import annotations

import ctypes as ct
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np
import pytest
from evat import fmu
from evat.fmu.part_model import fmu_facts_of, model_of, shown_variables
from evat.model import BuildError, Run
from evat.models.drive import drive
from evat.native import kernel
from fmpy import read_model_description
from fmpy.validation import validate_fmu
from raw_fmi import ERROR, OK, Door, Instance
from two_doors import Values, in_fmi

SLIM = tuple(part for part in fmu.parts() if fmu_facts_of(part).shown)
PERIOD = 5e-5  # [s]
TIMES = np.linspace(0, 3 * PERIOD, 61)
# What each is for, away from its starts; inputs by their values at TIMES.
INPUTS: Mapping[str, Mapping[str, np.ndarray]] = {
    "evat_guideway": {"slip_velocity": 0.3 * np.cos(1e5 * TIMES), "normal_load": np.linspace(10, 20, 61)},
    "evat_slip": {"slip_velocity": 0.3 * np.cos(1.3e5 * TIMES), "uncut_thickness": np.linspace(5e-5, 1e-4, 61)},
    "evat_cut": {"cutting_speed": np.linspace(0.15, 0.2, 61)},
}
VALUES: Mapping[str, Values] = {
    "evat_guideway": {"F_C": 5.0, "sigma0": 2e6, "load_dependence": 1.0, "load_dependence.n": 0.5},
    "evat_slip": {"rake_angle": 0.1, "thermal_softening": 1.0, "thermal_softening.k_Q": 100.0, "shear_angle_principle": "minimum_energy"},
    "evat_cut": {"rake_angle": 0.05, "feed": 6e-5, "thermal_damping": 1.0, "sigma0": 3e6},
}
BOTH = pytest.mark.parametrize("version", [2, 3])
EACH = pytest.mark.parametrize("part", SLIM)


def outputs(part: str) -> tuple[str, ...]:
    return tuple(v.name for v in model_of(part).variables if v.causality == "output")


@EACH
def test_slim_is_slim(part: str) -> None:
    variables = model_of(part).variables
    assert len(outputs(part)) <= 12
    assert len([v for v in variables if v.causality == "parameter"]) <= 34  # a fifth of the contact's
    assert len(model_of(part).states) <= 5


@pytest.mark.parametrize("part", fmu.parts())
def test_no_fmu_has_more_outputs_than_tools_plot_at_once(part: str) -> None:
    assert 0 < len(outputs(part)) <= 12


@pytest.mark.parametrize(("part", "version"), [("evat_guideway", 2), ("evat_slip", 3), ("evat_cut", 2)])
def test_checkers_find_nothing(part: str, version: int, fmus: dict[str, Path]) -> None:
    path = fmus[f"{part}-fmi{version}"]
    assert validate_fmu(str(path)) == []
    assert [v.name for v in read_model_description(str(path), validate=False).modelVariables] == [v.name for v in model_of(part).variables]


@BOTH
@EACH
def test_it_says_what_the_whole_contact_says(part: str, version: int, fmus: dict[str, Path]) -> None:
    """To the last bit: the same laws, the same steps."""
    run = Run(TIMES, INPUTS[part], outputs(part))
    slim = drive(fmus[f"{part}-fmi{version}"], run, VALUES[part])
    whole = drive(fmus[f"fmi{version}"], run, {**fmu_facts_of(part).start, **VALUES[part]})
    for name in run.outputs:
        assert np.array_equal(slim[name], whole[name]), name
    assert np.ptp(slim["friction_force"]) > 1


@BOTH
@EACH
def test_a_solver_needs_no_state_that_is_not_shown(part: str, version: int, fmus: dict[str, Path]) -> None:
    path, grid = str(fmus[f"{part}-fmi{version}"]), PERIOD / 20
    names = [name for name in outputs(part) if name != "clamped_count"]
    held = {name: float(column[0]) for name, column in INPUTS[part].items()}
    values = in_fmi({**VALUES[part], **held, "relative_tolerance": 1e-10})
    common = {"start_values": values, "output": names, "stop_time": 2.3 * PERIOD, "output_interval": grid}
    own = np.asarray(fmpy.simulate_fmu(path, fmi_type="CoSimulation", **common)).view(np.ndarray)
    solver = fmpy.simulate_fmu(path, fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-10, record_events=False, **common)
    inside = np.abs(own["time"] / PERIOD - np.round(own["time"] / PERIOD)) > 1e-6  # at the end of a window either mean is right
    for name in names:
        ours, theirs = (np.asarray(trace).view(np.ndarray)[name][inside] for trace in (own, solver))
        assert theirs == pytest.approx(ours, rel=0, abs=1e-5 * np.abs(ours).max()), name


def test_every_file_has_a_token_of_its_own(fmus: dict[str, Path]) -> None:
    tokens = [read_model_description(str(path), validate=False).guid for path in fmus.values()]
    assert len(set(tokens)) == len(tokens) == 2 * len(fmu.parts()) + 1


@BOTH
@EACH
def test_its_state_comes_back_from_bytes(part: str, version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    """With what it does not show as it starts here, which is not as the whole contact starts."""
    door = Door(fmus[f"{part}-fmi{version}"], tmp_path)
    one, other = Instance(door), Instance(door)
    one.start()
    assert one.step(0.0, 1.3 * PERIOD) == OK
    assert other.deserialize(one.serialize()) == OK, other.lines
    assert other.get(*outputs(part)) == one.get(*outputs(part))
    for each in (one, other):
        each.free()


@BOTH
def test_a_token_opens_the_fmus_of_its_model_and_version_alone(version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    """One binary serves all FMUs of a model: which it is the token says."""
    door, other, partner = (
        Door(fmus[name], tmp_path) for name in (f"evat_guideway-fmi{version}", f"evat_cut-fmi{5 - version}", f"spindle-fmi{version}")
    )
    for token in (other.token, partner.token, kernel.token()):
        refused = Instance(door, token=token.encode())
        assert refused.pointer is None
        line = refused.said()
        assert f"{door.token} of EvatGuideway" in line
        assert token in line
    whole = Instance(door, token=Door(fmus[f"fmi{version}"], tmp_path).token.encode())
    assert whole.pointer is not None
    whole.free()


@BOTH
def test_what_is_not_shown_is_out_of_reach(version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    door = Door(fmus[f"evat_guideway-fmi{version}"], tmp_path)
    one = Instance(door)
    count = len(model_of("evat_guideway").variables)
    status, _ = one.get_as("real", [count + 1])
    assert status == ERROR
    assert f"there is no variable with value reference {count + 1}; allowed is 1 to {count}" in one.said()
    one.free()
    one = Instance(door, model_exchange=True).start({"slip_velocity": 0.01})
    wrong = (ct.c_double * len(kernel.states()))()
    assert one.call("GetContinuousStates", wrong, ct.c_size_t(len(wrong))) == ERROR
    assert f"the FMU has {len(model_of('evat_guideway').states)}" in one.said()
    one.free()


@BOTH
def test_a_guideway_does_not_warn_of_what_a_chip_bears(version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    """1000 N backwards are more than the shear plane of a chip of 0.1 mm takes."""
    one = Instance(Door(fmus[f"evat_guideway-fmi{version}"], tmp_path)).start({"slip_velocity": -0.1, "F_C": 1000.0, "F_S": 1200.0})
    for n in range(20):
        assert one.step(n * 1e-3, 1e-3) == OK, one.lines
    assert one.get("friction_force")[0] < -800
    assert one.get("clamped_count") == [0]
    assert one.lines == []
    one.free()


@BOTH
def test_names_in_log_lines_come_with_the_reference_that_the_host_knows(version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    door = Door(fmus[f"evat_cut-fmi{version}"], tmp_path)
    one = Instance(door)
    assert one.set({"feed": -1.0}) == ERROR
    assert f"feed = -1 m (value reference {door.reference['feed']})" in one.said()
    one.free()


@BOTH
def test_a_forged_state_brings_in_nothing_that_is_not_shown(version: int, fmus: dict[str, Path], tmp_path: Path) -> None:
    from test_fmu_state import SEAL, _in_model, _sealed

    door = Door(fmus[f"evat_guideway-fmi{version}"], tmp_path)
    one = Instance(door).start({"slip_velocity": 0.01})
    data = bytearray(one.serialize())
    assert one.deserialize(bytes(data)) == OK
    place = _in_model("value", kernel.variable("width").index)
    data[place : place + 8] = np.float64(2e-3).tobytes()
    assert one.deserialize(_sealed(bytes(data), SEAL)) == ERROR
    assert "what this FMU does not show is not as it starts" in one.said()
    one.free()


def test_a_file_that_shows_what_there_is_not_is_refused() -> None:
    facts = fmu_facts_of("evat_guideway")
    with pytest.raises(BuildError, match="no_such: there is no such variable"):
        shown_variables(replace(facts, shown=[*facts.shown, "no_such"]))
    with pytest.raises(BuildError, match="bristle_rate must be shown"):
        shown_variables(replace(facts, shown=[name for name in facts.shown if name != "bristle_rate"]))
    with pytest.raises(BuildError, match=r"feed: there is no such output"):
        shown_variables(replace(facts, connected=["friction_force", "feed"]))
