"""Does an FMU that is driven along a record follow it, say what it did, and leave nothing behind, whatever goes wrong?"""

from __future__ import annotations

import math
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from evat.model import EvatError, FmuError, ParameterError, Run, SimulationError
from evat.models import drive as drive_module
from evat.models.drive import Driver, drive
from evat.models.simulate import simulate
from evat.native import kernel
from fmpy import read_model_description

SLIDING: dict[str, float | str | bool] = {"kinematics": "external", "friction_law": "lugre", "F_C": 3.0, "F_S": 4.0}
OUTPUTS = ("friction_force", "friction_impulse", "in_contact", "step_count")
TIMES = np.linspace(0, 2e-3, 81)
SLIP = 0.3 * np.sin(2e4 * TIMES**1.2)


@pytest.fixture(params=[2, 3], ids=["FMI2", "FMI3"])
def fmu(request: pytest.FixtureRequest) -> Path:
    path: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return path


@pytest.fixture(autouse=True)
def scratch(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where temporary folders are made; empty again after every test."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


def token(fmu: Path) -> str:
    return str(read_model_description(str(fmu), validate=False).guid)


def sliding(times: np.ndarray = TIMES, slip: np.ndarray = SLIP) -> Run:
    return Run(times, {"slip_velocity": slip}, OUTPUTS)


def test_fmi2_follows_a_record_as_the_kernel_does(fmi2_fmu: Path, scratch: Path) -> None:
    """Both go on linearly between the samples: the same results but for the rounding of rates."""
    many = Run(np.linspace(0, 1e-2, 600), {"slip_velocity": 0.3 * np.sin(np.arange(600.0))}, OUTPUTS)
    for run in (sliding(), many):
        shares: list[float] = []
        trace = drive(fmi2_fmu, run, SLIDING, progress=shares.append)
        ours = simulate({name: value for name, value in SLIDING.items()}, times=run.times, inputs=run.inputs, outputs=OUTPUTS)
        for name in OUTPUTS:
            largest = float(np.abs(ours[name]).max())
            # a rate is a difference over a step, rounded, and the choice of the next step follows roundings: a thousandth of the tolerance
            assert np.abs(trace[name] - ours[name]).max() <= 1e-7 * largest, name
        assert 0 < shares[0] < shares[-1] == 1
        assert shares == sorted(shares)
    assert list(scratch.iterdir()) == []


def test_fmi3_follows_a_record_by_the_mean_of_each_step(fmi3_fmu: Path) -> None:
    """It has no input derivatives: of second order in the step, so four times nearer to the linear motion for steps of half the length."""
    errors = []
    for count in (401, 801, 1601):
        times = np.linspace(0, 1e-3, count)
        run = sliding(times, 0.3 + 0.1 * np.sin(5e3 * times))
        linear = simulate({name: value for name, value in SLIDING.items()}, times=times, inputs=run.inputs, outputs=OUTPUTS)
        errors.append(np.abs(drive(fmi3_fmu, run, SLIDING)["friction_impulse"] - linear["friction_impulse"]).max())
    assert errors[2] < errors[0] / 8
    assert errors[2] < 1e-5 * 3.0 * 1e-3


def test_values_arrive_whatever_their_type(fmu: Path) -> None:
    """Steady sliding: F_C + sigma2 v with or without the effect; the choice by its name; the switch as a truth value or a number."""
    base: dict[str, float | str | bool] = {**SLIDING, "F_C": 3, "F_S": 3.0, "sigma2": 2.0, "proxy_source": "proxy_speed"}
    base |= {"proxy_speed": kernel.variable("theta_ref").start, "sigma0": 1e6, "thermal_softening.k_Q": 1e5}
    run = Run(np.linspace(0, 1e-2, 5), {"slip_velocity": np.full(5, 0.5)}, ("friction_force",))
    for values, expected in (
        ({}, 4.0),
        ({"thermal_softening": True}, 3.7),
        ({"thermal_softening": 1.0}, 3.7),
        ({"thermal_softening": False}, 4.0),
        ({"friction_law": "coulomb"}, 3.0),
    ):
        assert drive(fmu, run, {**base, **values})["friction_force"][-1] == pytest.approx(expected, rel=1e-6)


def test_the_trace_says_units_and_how_it_was_made(fmu: Path) -> None:
    trace = drive(fmu, sliding(), {**SLIDING, "thermal_softening": True})
    assert dict(trace.units) == {name: kernel.variable(name).unit for name in OUTPUTS}
    assert trace.made_by["fmu"] == fmu.name
    assert trace.made_by["token"] == token(fmu)
    assert trace.made_by["values"] == {**SLIDING, "thermal_softening": 1.0}
    assert set(trace["in_contact"]) <= {0.0, 1.0}
    assert trace["step_count"][-1] >= TIMES.size - 1


def test_without_inputs_the_ellipse_runs_on_its_own(fmu: Path) -> None:
    times = np.linspace(3.0, 3.0 + 1e-4, 41)
    trace = drive(fmu, Run(times, {}, ("principal_force", "mean_contact_ratio")), {})
    assert trace["principal_force"].max() > 10
    assert 0 < trace["mean_contact_ratio"][-1] < 1


@pytest.mark.parametrize(
    ("values", "what"),
    [
        ({"cutting_sped": 1.0}, "no variable 'cutting_sped'"),
        ({"F_C": "much"}, "a number in N is needed"),
        ({"F_C": math.nan}, "setting F_C = nan: .*F_C"),
        ({"F_C": -1.0}, "setting F_C = -1.0: .*F_C"),
        ({"friction_law": "stribeck"}, "allowed are coulomb, lugre"),
        ({"friction_law": 1.5}, "allowed are coulomb, lugre"),
        ({"friction_law": math.inf}, "allowed are coulomb, lugre"),
        ({"friction_law": 99}, "setting friction_law = 99: .*friction_law"),
        ({"bristle.seed": "one"}, "allowed are whole numbers"),
        ({"thermal_softening": "false"}, "allowed are True and False"),
        ({"thermal_softening": 2.0}, "allowed are True and False"),
        ({"friction_force": 1.0}, "friction_force"),
    ],
)
def test_a_value_that_cannot_be_is_refused(fmu: Path, scratch: Path, values: dict[str, float | str | bool], what: str) -> None:
    with pytest.raises(EvatError, match=what):
        drive(fmu, sliding(), {**SLIDING, **values})
    assert list(scratch.iterdir()) == []


@pytest.mark.parametrize(
    ("run", "error", "what"),
    [
        (sliding(TIMES[::-1]), ParameterError, "increasing"),
        (sliding(np.zeros(81)), ParameterError, "increasing"),
        (sliding(np.where(TIMES > 1e-3, np.nan, TIMES)), ParameterError, "finite"),
        (sliding(TIMES[:1], SLIP[:1]), ParameterError, "at least 2"),
        (sliding(TIMES, SLIP[:-1]), ParameterError, "slip_velocity has 80 samples, the clock has 81"),
        (sliding(TIMES, np.where(TIMES > 1e-3, np.nan, SLIP)), SimulationError, r"step to t = 0\.00102"),
        (sliding(TIMES, np.where(TIMES == 0, np.inf, SLIP)), SimulationError, "first inputs: .*slip_velocity"),
        (sliding(TIMES, np.where(TIMES > 1e-3, 1e9, SLIP)), SimulationError, r"step to t = 0\.00102"),
        (Run(TIMES, {"slip": SLIP}, OUTPUTS), ParameterError, "no variable 'slip'"),
        (Run(TIMES, {"slip_velocity": SLIP}, ("force",)), ParameterError, "no variable 'force'"),
        (Run(TIMES, {"friction_force": SLIP}, OUTPUTS), SimulationError, "friction_force"),
    ],
)
def test_a_record_that_cannot_be_followed_is_refused(fmu: Path, scratch: Path, run: Run, error: type[EvatError], what: str) -> None:
    with pytest.raises(error, match=what):
        drive(fmu, run, SLIDING)
    assert list(scratch.iterdir()) == []


def changed(
    fmu: Path, path: Path, *, leave_out: str = "nothing", old: bytes = b"nothing", new: bytes = b"", extra: str | None = None
) -> Path:
    """A copy of the FMU without some files, with other words in its description, or with one file more."""
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(path, "w") as copy:
        for name in source.namelist():
            if not name.startswith(leave_out):
                content = source.read(name)
                copy.writestr(name, content.replace(old, new) if name == "modelDescription.xml" else content)
        if extra is not None:
            copy.writestr(extra, b"hostile")
    return path


def test_what_is_no_fmu_for_this_machine_is_refused(fmu: Path, tmp_path: Path, scratch: Path) -> None:
    torn = tmp_path / "torn.fmu"
    torn.write_bytes(fmu.read_bytes()[:5000])
    cases = {
        tmp_path / "nowhere.fmu": "no FMU that can be read",
        torn: "no FMU that can be read",
        changed(fmu, tmp_path / "a.fmu", leave_out="modelDescription.xml"): "no FMU that can be read",
        changed(fmu, tmp_path / "b.fmu", leave_out="binaries"): "cannot be instantiated here",
        changed(fmu, tmp_path / "c.fmu", old=token(fmu).encode(), new=b"{0}"): "cannot be instantiated here .*; it said: ",
        changed(fmu, tmp_path / "d.fmu", extra="/etc/evat-was-here"): "no FMU that can be read.*outside of the archive's folder",
        changed(fmu, tmp_path / "e.fmu", old=b"CoSimulation", new=b"ScheduledExecution"): "FMU",
    }
    for path, what in cases.items():
        with pytest.raises(FmuError, match=what) as caught:
            drive(path, sliding(), SLIDING)
        assert path.name in str(caught.value)
    assert list(scratch.iterdir()) == []


def test_a_library_that_cannot_be_loaded_leaves_the_process_where_it_was(fmu: Path, tmp_path: Path, scratch: Path) -> None:
    """fmpy goes into its folder to load it, and stayed there as that failed: the folder is gone once the error is told."""
    broken, before = tmp_path / "broken.fmu", Path.cwd()
    with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(broken, "w") as copy:
        for name in source.namelist():
            copy.writestr(name, b"not a library" if name.startswith("binaries/") else source.read(name))
    with pytest.raises(FmuError, match="cannot be instantiated here"):
        drive(broken, sliding(), SLIDING)
    assert Path.cwd() == before
    assert list(scratch.iterdir()) == []


def test_no_file_of_an_fmu_is_unpacked_outside_its_folder(fmu: Path, tmp_path: Path, scratch: Path) -> None:
    hostile = changed(fmu, tmp_path / "f.fmu", extra="../../evat-was-here")
    with pytest.raises(FmuError, match="outside of the archive's folder"):
        drive(hostile, sliding(), SLIDING)
    assert not list(tmp_path.rglob("evat-was-here"))
    assert list(scratch.iterdir()) == []


def test_a_driver_keeps_what_the_fmu_logs(fmu: Path) -> None:
    values = {
        **SLIDING,
        "thermal_softening": True,
        "thermal_softening.k_Q": 1e6,
        "sigma0": 1e5,
        "proxy_source": "proxy_speed",
        "proxy_speed": 5.0,
    }
    with Driver(fmu, values) as driver:
        driver.follow(sliding())
        assert any("stiffness" in line for line in driver.log)


def test_of_an_fmu_that_runs_again_no_more_is_read_than_it_takes_to_run(
    fmi2_fmu: Path, fmi3_fmu: Path, scratch: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its description once, and none of its sources; another file in its place is read anew."""
    read, there = list[str](), set[str]()

    def description(path: str, validate: bool) -> object:
        read.append(path)
        return read_model_description(path, validate=validate)

    monkeypatch.setattr(drive_module.fmpy, "read_model_description", description)
    copy = tmp_path / "one.fmu"
    for original, reads in ((fmi2_fmu, 1), (fmi3_fmu, 2)):
        copy.write_bytes(original.read_bytes())
        for _ in range(2):
            with Driver(copy, SLIDING) as driver:
                there |= {path.name for path in scratch.glob("*/*")}
                assert driver.description.fmiVersion[0] == str(1 + reads)
            assert len(read) == reads
    assert {"binaries", "modelDescription.xml"} <= there
    assert not there & {"documentation", "sources"}
