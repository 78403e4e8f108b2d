"""Do importers that others wrote give the same answer with our systems? Compared at the times that each of them reports.

All of them couple as simply as can be: every component steps from the last values that the others have shown. The 1995 cases are held to
the published numbers, the cut to a run of our own that is converged, and all importers to one of them.
"""

from __future__ import annotations

import functools
import importlib.util
import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import containers
import evidence
import fmpy
import guide_table
import lugre_1995 as published
import numpy as np
import pytest
from coupled import run
from evat.systems.model import Port
from evat.systems.ssp.read import read
from fmpy.ssp.simulation import simulate_ssp

HERE = Path(__file__).resolve().parent
PORTS: dict[str, list[Port]] = {
    "stick_slip": [("drive", "table_position"), ("drive", "table_velocity"), ("guideway", "friction_force")],
    "hunting": [("drive", "table_position"), ("drive", "table_velocity"), ("guideway", "friction_force")],
    "evat_turning": [("contact", "principal_force"), ("structure", "displacement_x"), ("spindle", "cutting_speed")],
}
# Communication step and stop [s], and every how many steps the answer is looked at.
CASES = {"stick_slip": (1e-3, 28.0, 1), "hunting": (1e-3, 125.0, 1), "evat_turning": (1e-6, 5e-4, 10)}

Columns = dict[Port, np.ndarray]
Importer = Callable[[Path, Path, float, float, int, list[Port]], tuple[np.ndarray, Columns]]


def needs(package: str) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: pip install 'evat[importers]'")


def asked(script: str, system: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
    """In a process of its own: a host that crashes must not take the tests with it."""
    names = [".".join(port) for port in ports]
    command = [sys.executable, str(HERE / script), str(system), repr(step), repr(stop), str(every), *names]
    result = subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=300, check=False)
    line = next((line for line in result.stdout.splitlines() if line.startswith("RESULT ")), None)
    if line is None and "libtbb" in result.stderr:
        pytest.skip("ecospy needs the system library libtbb.so.12 (Debian: apt install libtbb12)")
    assert line is not None, result.stderr[-2000:]
    answered = json.loads(line.removeprefix("RESULT "))
    return np.array(answered["times"]), {port: np.array(answered["columns"][name]) for port, name in zip(ports, names, strict=True)}


def by_cosim(ssp: Path, folder: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
    needs("libcosimpy")
    with zipfile.ZipFile(ssp) as packed:
        packed.extractall(folder)  # it wants a folder
    return asked("host_cosim.py", folder, step, stop, every, ports)


def by_ecos(ssp: Path, folder: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
    needs("ecospy")
    return asked("host_ecos.py", ssp, step, stop, every, ports)


def by_fmpy(ssp: Path, folder: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
    """It binds no parameters by itself; and its row of a time holds what stands at the end of the step that begins there."""
    system = read(ssp, folder)
    values = [
        SimpleNamespace(name=f"{name}.{key}", value=value) for name, part in system.components.items() for key, value in part.values.items()
    ]
    rows = simulate_ssp(str(ssp), stop_time=stop, step_size=step, parameter_set=SimpleNamespace(parameters=values))
    kept = slice(every - 1, round(stop / step), every)  # it may go a step too far, by the rounding of its clock
    return (rows["time"] + step)[kept], {port: rows[".".join(port)][kept] for port in ports}


def in_one(make: Callable[[Path, Path, float, list[Port]], Path]) -> Importer:
    def by_container(ssp: Path, folder: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
        names = ["_".join(port) for port in ports]
        rows = fmpy.simulate_fmu(str(make(ssp, folder, step, ports)), stop_time=stop, output_interval=every * step, output=names)
        return rows["time"][1:], {port: rows[name][1:] for port, name in zip(ports, names, strict=True)}

    return by_container


def by_toolbox(ssp: Path, folder: Path, step: float, stop: float, every: int, ports: list[Port]) -> tuple[np.ndarray, Columns]:
    needs("fmu_manipulation_toolbox")
    return in_one(containers.by_toolbox)(ssp, folder, step, stop, every, ports)


IMPORTERS: dict[str, Importer] = {
    "fmpy": by_fmpy,
    "fmpy-container": in_one(containers.by_fmpy),
    "libcosim": by_cosim,
    "ecos": by_ecos,
    "toolbox-container": by_toolbox,
}


@pytest.fixture(scope="module")
def answer(systems: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], tuple[np.ndarray, Columns]]:
    """What an importer says of a system; each is asked once."""

    @functools.cache
    def ask(importer: str, name: str) -> tuple[np.ndarray, Columns]:
        step, stop, every = CASES[name]
        times, columns = IMPORTERS[importer](systems[name], tmp_path_factory.mktemp("work") / "in", step, stop, every, PORTS[name])
        assert times == pytest.approx(every * step * np.arange(1, round(stop / step) // every + 1), rel=1e-9)
        return times, columns

    return ask


def block(times: np.ndarray, columns: Columns) -> published.Motion:
    return published.Motion(times, *(columns[port] for port in PORTS["stick_slip"]))


def apart(first: Columns, second: Columns) -> float:
    """Largest difference of two answers, as a share of each signal's largest value."""
    return max(float(np.max(np.abs(first[port] - second[port])) / np.max(np.abs(second[port]))) for port in first)


@pytest.mark.parametrize("importer", IMPORTERS)
def test_stick_slip_as_in_1995(answer: Callable[[str, str], tuple[np.ndarray, Columns]], importer: str) -> None:
    """All lag by a step more than our own coupling, so the slip begins some steps of 1 ms off: a thousandth of the period, 6.4 s."""
    simulated = published.stick_slip(block(*answer(importer, "stick_slip")))
    off = {key: simulated[key] / value - 1 for key, value in published.STICK_SLIP.items()}
    print(f"{importer:18} stick-slip: " + ", ".join(f"{key} {100 * value:+.3f} %" for key, value in off.items()))
    assert simulated == pytest.approx(published.STICK_SLIP, rel=5e-3)
    evidence.hold("importers, stick-slip", 100 * max(map(abs, off.values())))
    guide_table.hold(importer, "stick-slip", 100 * off["period"], 100 * off["v_max"])


@pytest.mark.parametrize("importer", [pytest.param(name, marks=pytest.mark.campaign) if name != "fmpy" else name for name in IMPORTERS])
def test_hunting_as_in_1995(answer: Callable[[str, str], tuple[np.ndarray, Columns]], importer: str) -> None:
    simulated = published.hunting(block(*answer(importer, "hunting")))
    off = {key: simulated[key] / value - 1 for key, value in published.HUNTING.items()}
    print(f"{importer:18} hunting: " + ", ".join(f"{key} {100 * value:+.3f} %" for key, value in off.items()))
    assert simulated == pytest.approx(published.HUNTING, rel=5e-3)
    span = (simulated["highest"] - simulated["lowest"]) / (published.HUNTING["highest"] - published.HUNTING["lowest"]) - 1
    evidence.hold("importers, hunting", 100 * max(map(abs, off.values())))
    guide_table.hold(importer, "hunting", 100 * span, 100 * off["period"])


@pytest.mark.parametrize("importer", IMPORTERS)
def test_turning_is_the_same_cut(answer: Callable[[str, str], tuple[np.ndarray, Columns]], importer: str, systems: dict[str, Path]) -> None:
    """Against a converged run of our own; entry and exit of the tool are steps of the force, so a lag of 1 us of 50 is what may show. As
    the first cycle ends its mean powers come on, and the force jumps: a sample there lies on either side."""
    step, stop, every = CASES["evat_turning"]
    times, columns = answer(importer, "evat_turning")
    good, _ = run(systems["evat_turning"], step=step / 2, stop=stop, every=2 * every)
    at_jump = np.isclose(times, 5e-5, rtol=1e-6)
    assert at_jump.sum() == 1
    columns = {port: column[~at_jump] for port, column in columns.items()}
    expected = {port: good[".".join(port)][1:][~at_jump] for port in PORTS["evat_turning"]}
    print(f"{importer:18} turning: {100 * apart(columns, expected):.3f} %")
    assert apart(columns, expected) < 0.03
    evidence.hold("importers, turning", 100 * apart(columns, expected))
    guide_table.hold(importer, "turning", 100 * apart(columns, expected))


@pytest.mark.parametrize("importer", [name for name in IMPORTERS if name != "fmpy"])
def test_importers_agree(answer: Callable[[str, str], tuple[np.ndarray, Columns]], importer: str) -> None:
    """Beyond the coupling error all do the same arithmetic; they differ in what a component sees in the very first step."""
    difference = apart(answer(importer, "evat_turning")[1], answer("fmpy", "evat_turning")[1])
    print(f"{importer:18} turning: {100 * difference:.4f} % from fmpy")
    assert difference < 0.02
