"""Does a sweep say for each point what a run of its own says, wherever it is carried out?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coupled import run
from evat.commands.main import app
from evat.files.table import read_table, read_texts
from evat.model import ParameterError
from evat.systems.model import SspError
from evat.systems.ssp.read import read
from evat.systems.sweep import Row, Sweep, SweepAxis, axis, sweep, worth
from typer.testing import CliRunner

WISHES = {"stop": 0.05, "step": 1e-3}


def rows_of(path: Path, folder: Path, cluster: object = None) -> list[Row]:
    system = read(path, folder)
    axes = [axis(system, "path.speed=0.05:0.15:3"), axis(system, "drive.pid_gain=2,4")]
    return sweep(path, axes, {}, WISHES, cluster=cluster)


def test_each_point_is_a_run_of_its_own(systems: dict[str, Path], tmp_path: Path) -> None:
    rows = rows_of(systems["stick_slip"], tmp_path / "in")
    assert [row.place for row in rows] == [(i, j) for i in range(3) for j in range(2)]
    trace, _ = run(systems["stick_slip"], {"path": {"speed": 0.15}, "drive": {"pid_gain": 4.0}}, **WISHES)
    late = trace.times >= 0.025 - 1e-9
    means = {name: np.mean((column[late][1:] + column[late][:-1]) / 2) for name, column in trace.columns.items()}
    assert rows[-1].means == pytest.approx(means, rel=1e-12)
    assert not any(row.failure for row in rows)


def test_processes_are_started_where_they_save_time() -> None:
    assert worth(4, 10) == 1  # evat_turning: 1.1 s of processor time in one, 1.3 s in each of two
    assert worth(4, 100_000) is None  # 6.4 s in one, 4.2 s in each of two
    assert worth(50, 10) is None  # each loads the system


def test_a_cluster_gives_the_same_rows(systems: dict[str, Path], tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    from evat.identification.searching.cluster import Cluster

    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None) as local,
        Cluster(local.scheduler_address) as cluster,
    ):
        rows = rows_of(systems["stick_slip"], tmp_path / "in", cluster)
    assert rows == rows_of(systems["stick_slip"], tmp_path / "again")


@pytest.mark.parametrize("places", ["dissipative,as_published", "1,2"])
def test_a_choice_is_swept_by_its_names_or_by_the_numbers_of_the_fmu(systems: dict[str, Path], tmp_path: Path, places: str) -> None:
    over = axis(read(systems["stick_slip"], tmp_path / "in"), f"guideway.damping_mode={places}")
    assert over.texts == ("dissipative", "as_published")
    assert over.values[1] == {"guideway": {"damping_mode": "as_published"}}


def test_a_choice_that_there_is_not_is_refused_before_anything_runs(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["stick_slip"], tmp_path / "in")
    for wrong in ("passive", "0", "3"):
        with pytest.raises(ParameterError, match=rf"guideway.damping_mode = '{wrong}': allowed are dissipative \(1\), as_published \(2\)"):
            axis(system, f"guideway.damping_mode=dissipative,{wrong}")


def test_a_point_that_fails_says_why_and_the_others_stand(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["stick_slip"], tmp_path / "in")
    rows = sweep(systems["stick_slip"], [axis(system, "drive.table_mass=-1,1")], {}, WISHES)
    assert "table_mass = -1" in rows[0].failure
    assert not rows[0].means
    assert not rows[1].failure
    assert rows[1].means


def test_a_sweep_that_lacks_a_run_ends_with_a_status(systems: dict[str, Path], tmp_path: Path) -> None:
    to = tmp_path / "sweep.csv"
    asked = ["system", "sweep", str(systems["stick_slip"]), "--over", "drive.table_mass=-1,1", "--stop", "0.02", "-o", str(to)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 1
    assert "1 of 2 runs failed" in result.output
    assert read_table(to).column("drive.table_mass [kg]", "kg").size == 2


def test_axes_that_make_no_sense(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["stick_slip"], tmp_path / "in")
    for text, match in (
        ("drive.table_mass", "FIRST:LAST:COUNT"),
        ("drive.table_mass=1:2", "COUNT"),
        ("drive.table_mass=1:2:0", "count from 1"),
        ("motor=lugre-1995", "no component 'motor'"),
        ("drive.mass=1:2:3", "no variable 'mass'"),
        ("guideway.slip_velocity=1:2:3", "is fed by"),
    ):
        with pytest.raises((ParameterError, SspError), match=match):
            axis(system, text)


def rows_with(ratios: list[float]) -> tuple[Row, ...]:
    """Runs of a cut that show these speed ratios."""
    means = [{"contact.speed_ratio": ratio, "contact.mean_feed_force": float(n)} for n, ratio in enumerate(ratios)]
    return tuple(Row((n,), each, "") for n, each in enumerate(means))


def drawn_over(name: str, unit: str, places: list[float], ratios: list[float], beside: list[float] | None = None) -> list[list[float]]:
    """Where the lines of a plot have their points."""
    over = SweepAxis(name, unit, tuple(map(repr, places)), tuple({"contact": {}} for _ in places))
    units = {"contact.speed_ratio": "1", "contact.mean_feed_force": "N"}
    swept = Sweep((over,), rows_with(ratios), units, rows_with(beside or []))
    return [line.get_xdata().tolist() for line in swept.plot("contact.mean_feed_force").axes[0].lines]


def test_a_speed_that_the_speed_ratio_does_not_follow_is_the_axis_itself() -> None:
    """Four Stribeck velocities stood at one speed ratio, in whatever order: the feed force only just brakes the spindle."""
    places = [0.005, 0.01, 0.02, 0.04]
    hardly = [0.26522558 * (1 + 1e-7 * n) for n in range(4)]
    assert drawn_over("contact.v_s", "m/s", places, hardly) == [pytest.approx([5, 10, 20, 40])]  # mm/s
    assert drawn_over("spindle.speed_set", "rad/s", places, [4.0, 3.0, 5.0, 6.0]) != [[3.0, 4.0, 5.0, 6.0]]
    assert drawn_over("spindle.speed_set", "rad/s", places, [0.5, 1.0, 2.0, 4.0]) == [[0.5, 1.0, 2.0, 4.0]]
    assert drawn_over("spindle.speed_set", "rad/s", places, [0.5, np.nan, 2.0, 4.0])[0][:3] == [0.5, 2.0, 4.0]  # one run failed


def test_what_was_run_beside_is_drawn_over_its_own_speed_ratio() -> None:
    """With twice the radius dashed runs of twice the ratio stood at that of the others; one without vibration has none."""
    beside = [0.32, 0.0, 1.27]
    assert drawn_over("spindle.speed_set", "rad/s", [5.0, 10.0, 20.0], [0.16, 0.3, 0.6], beside) == [[0.16, 0.3, 0.6], [0.3, 0.32, 1.27]]


def test_the_command_writes_table_and_map(systems: dict[str, Path], tmp_path: Path) -> None:
    to = tmp_path / "sweep.csv"
    grid = ["--over", "contact=regularised/copper,regularised/al-7075-t6", "--over", "contact.amplitude_x=4 um,6 um"]
    conventional = ["--beside", "contact.amplitude_x=0", "--beside", "contact.amplitude_y=0"]
    asked = ["system", "sweep", str(systems["evat_turning"]), *grid, *conventional, "--stop", "2e-4", "-o", str(to)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    table = read_table(to)
    assert read_texts(to, "contact") == ("regularised/copper",) * 2 + ("regularised/al-7075-t6",) * 2
    assert {"contact.amplitude_x [m]", "contact.mean_principal_force [N]", "contact.speed_ratio [1]"} <= set(table.columns)
    wider = table.column("contact.speed_ratio [1]", "1")
    assert wider[0] / wider[1] == pytest.approx(1.5, rel=1e-3)  # HSR falls as the amplitude grows
    beside = table.column("contact.mean_principal_force beside [N]", "N")
    assert np.all(beside > 2 * table.column("contact.mean_principal_force [N]", "N"))  # that is what the vibration is for
    assert beside[0] == beside[1] != beside[2]  # the amplitude that was swept is put aside, the material is not
    assert to.with_suffix(".png").stat().st_size > 10_000
