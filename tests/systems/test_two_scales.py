"""Does averaging = cycle say of the cut on a machine what the run that follows every cycle says, for far less?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coupled import run
from evat.commands.main import app
from evat.files.table import read_table
from evat.model import ParameterError
from evat.studies.two_scales.system import SystemScales, compare
from evat.systems.model import SspError, System
from evat.systems.ssp.read import read
from typer.testing import CliRunner

FASTER = {"spindle": {"speed_set": 25.0}}  # from 10 towards 30 m/min
STEP, STOP = 1e-3, 0.02


@pytest.fixture(scope="module")
def turning(systems: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> System:
    return read(systems["evat_turning"], tmp_path_factory.mktemp("turning"))


@pytest.fixture(scope="module")
def scales(turning: System) -> SystemScales:
    """Steps of 2 us move the mean forces by 1e-4 from those of 1 us, which is far below what is asked here."""
    return compare(turning, FASTER, step=STEP, fine=2e-6, stop=STOP)


def test_the_mean_forces_are_those_of_the_resolved_cut(scales: SystemScales) -> None:
    """The first step knows nothing of how the tool gives way, whatever the contact does: 1 % is its coupling error. Later ones do."""
    cut = scales.cut
    assert cut.relative_error < 0.015
    assert cut.error.argmax() == 0
    assert cut.error[6:].max() < 1e-3 * cut.largest
    assert 0 < cut.typical_error < 5e-4
    assert cut.speed[-1] > 1.05 * cut.speed[0]  # so that something changes
    assert cut.means["resolved"][-1, 1] > 1.03 * cut.means["resolved"][1, 1]
    assert np.all(cut.error[1:] < 10 * cut.said[1:])  # of the averaging alone; the coupling adds to it


def test_the_machine_goes_the_same_way(scales: SystemScales) -> None:
    """What has 20 kHz in it may differ by that; the spindle filters it out, and the tool stands where the mean force puts it,
    but for a ripple of 2 % that the ends of the steps meet at the same phase of the vibration each time."""
    machine = scales.machine()
    assert {name.partition(".")[0] for name in machine} == {"structure", "spindle", "heat"}
    largest, apart = machine["spindle.cutting_speed"]
    assert apart < 5e-4 * largest
    resolved, cycle = (scales.runs[mode]["structure.displacement_x"][5:].mean() for mode in ("resolved", "cycle"))
    assert cycle == pytest.approx(resolved, rel=0.05)
    assert resolved < -4e-7


def test_it_is_at_least_ten_times_cheaper(scales: SystemScales) -> None:
    cut = scales.cut
    assert cut.cheaper > 10
    assert cut.internal_steps["resolved"] > 10 * cut.internal_steps["cycle"]
    assert scales.steps == {"resolved": pytest.approx(2e-6), "cycle": STEP}


def test_a_run_with_the_choice_is_the_averaged_one(systems: dict[str, Path], scales: SystemScales) -> None:
    trace, _ = run(systems["evat_turning"], {**FASTER, "contact": {"averaging": "cycle"}}, step=STEP, stop=STOP, every=1)
    assert trace.times.size == 21
    for name in ("contact.mean_principal_force", "spindle.cutting_speed"):
        assert np.array_equal(trace[name], scales.runs["cycle"][name])
    assert trace["contact.mean_feed_force"][1:] == pytest.approx(scales.cut.means["cycle"][:, 2], rel=1e-9)


def test_what_cannot_be_compared(systems: dict[str, Path], turning: System, tmp_path: Path) -> None:
    for wrong in ({"step": 1.5e-6}, {"step": -1.0}, {"step": float("nan")}, {"step": 1e-3, "stop": 1e-3}):
        with pytest.raises(ParameterError, match="whole multiple of the fine step"):
            compare(turning, **{"stop": 0.01, **wrong})
    for stop, near in (
        (2.51e-3, "0.002 s or 0.003 s"),
        (2.49e-3, "0.002 s or 0.003 s"),
        (1.6e-3, "0.002 s"),
    ):
        with pytest.raises(ParameterError, match=f"a stop at {stop:g} s is no whole number of steps of 0.001 s .*: stop at {near}, or"):
            compare(turning, step=1e-3, stop=stop)
    with pytest.raises(SspError, match=r"0 of its components .* have a choice 'averaging'"):
        compare(read(systems["stick_slip"], tmp_path), step=1e-2, stop=0.1)


def test_the_command_writes_both_and_says_what_it_saved(systems: dict[str, Path], tmp_path: Path) -> None:
    to = tmp_path / "both.parquet"
    asked = ["system", "averaging", str(systems["evat_turning"]), "--stop", "0.003", "--fine", "5e-6", "-o", str(to)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    assert "times cheaper; mean forces to" in result.output
    table = read_table(to)
    both = [table.column(f"mean_principal_force {mode} [N]", "N") for mode in ("resolved", "cycle")]
    assert both[0].size == 3
    assert np.max(np.abs(both[0] - both[1])) <= table.column("error [N]", "N").max() < 0.02 * both[0].max()
    assert to.with_suffix(".png").stat().st_size > 10_000
