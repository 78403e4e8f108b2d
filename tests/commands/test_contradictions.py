"""Is what contradicts itself, or would change nothing, refused before any work?"""

from __future__ import annotations

from pathlib import Path

import pytest
from command_line import evat


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ("simulate -v F_C=3 -v F_C=4", "F_C is given twice, by --value 'F_C=3' and by --value 'F_C=4'; keep one."),
        ("simulate -v run_out=true -v run_out=false", "run_out is given twice, by --value 'run_out=true' and by"),
        ("simulate -e run_out -v run_out=false", "run_out is given twice, by --effect run_out and by --value 'run_out=false'"),
        (
            "simulate --law lugre -v friction_law=coulomb",
            "friction_law is given twice, by --law lugre and by --value 'friction_law=coulomb'",
        ),
        ("simulate --principle minimum_energy -v shear_angle_principle=given", "shear_angle_principle is given twice, by --principle"),
        ("simulate --speed-unit m/s", "--speed-unit acts only with --set; give both, or leave it out."),
        ("simulate -i motion.csv --cycles 3", "--cycles acts only without --input; leave out one of both."),
        ("run --begin 5", "--begin acts only with --record"),
        ("run -v F_C=3", "--value acts only with --record"),
        ("run --record a.csv --family published", "--family acts only without --record"),
        ("sets --save a.ssv", "--save acts only with NAME; give both, or leave it out."),
        ("effects -o a.png", "--out acts only with NAME"),
        ("effects run_out --speed-unit m/s", "--speed-unit acts only with --set"),
        ("effects run_out -v F_C=3 -v F_C=3", "F_C is given twice"),
        ("identify rig -f F_C --law lugre -v friction_law=coulomb", "friction_law is given twice, by --law lugre"),
        ("identify rig -f F_C -e run_out -v run_out=false", "run_out is given twice, by --on run_out"),
        ("experiment orthogonal -o x -e run_out -v run_out=false", "run_out is given twice, by --effect run_out"),
        ("experiment init . --friction dahl -v friction_law=lugre", "friction_law is given twice, by --friction dahl"),
        ("experiment advise --speed-unit m/s", "--speed-unit acts only with --set"),
        ("experiment advise -v F_C=3 -v F_C=4", "F_C is given twice"),
    ],
)
def test_it_is_told_in_one_line(tmp_path: Path, arguments: str, said: str) -> None:
    done = evat(*arguments.split(), folder=tmp_path, columns=1000)
    assert done.returncode == 2, done.stdout
    assert said in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_of_a_system_too(systems: dict[str, Path], tmp_path: Path) -> None:
    for option, one, other, said in (
        ("-v", "drive.table_mass=2", "drive.table_mass=3", "drive.table_mass is given twice, at last as --value 'drive.table_mass=3'"),
        ("-s", "guideway=lugre-1995", "guideway=tribometer-5n", "component guideway has another set, too; keep one."),
    ):
        done = evat("system", "run", str(systems["stick_slip"]), option, one, option, other, folder=tmp_path, columns=1000)
        assert done.returncode == 2
        assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_friction_law_counts_beside_a_set(tmp_path: Path) -> None:
    """It was dropped where a set was named."""
    (tmp_path / "a.csv").write_text("t [s],v [m/s],F [N]\n" + "".join(f"{n},{n / 10},{n}\n" for n in range(9)), encoding="utf-8")
    done = evat("experiment", "init", ".", "-s", "lugre-1995", "-v", "friction_law=dahl", folder=tmp_path, columns=200)
    assert done.returncode == 0, done.stderr
    assert 'friction = "dahl"' in (tmp_path / "experiment.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize("named", [("-o", "evat.csv"), ("-o", "./evat.csv"), ()])
def test_a_result_does_not_take_the_place_of_its_record(tmp_path: Path, named: tuple[str, ...]) -> None:
    record = tmp_path / "evat.csv"
    record.write_text("time [s],slip_velocity [m/s]\n0,0\n1,0.1\n", encoding="utf-8")
    before = record.read_bytes()
    for command in (("simulate",), ("system", "run", "stick_slip")):
        to = named or (("-o", "evat.csv") if command[0] == "system" else ())
        done = evat(*command, "-i", "evat.csv", *to, folder=tmp_path, columns=1000)
        assert done.returncode == 2, done.stdout
        assert "--input and --out are both evat.csv: the result would take the record's place; name another table" in done.stderr
        assert record.read_bytes() == before
    assert list(tmp_path.iterdir()) == [record]


@pytest.mark.parametrize(
    ("columns", "more", "said"),
    [
        ("time [s],slip_velocity [mm/s],slip_velocity [m/s]", "", "slip_velocity is there twice, as 'slip_velocity [mm/s]' and as"),
        ("time [s],time [ms],slip_velocity [m/s]", "", "time is there twice, as 'time [s]' and as 'time [ms]'; keep one."),
        (
            "time [s],slip_velocity [m/s],uncut_thickness [m]",
            "-v slip_velocity=3",
            "slip_velocity is fed by the record motion.csv; a value for it would change nothing. Leave it out.",
        ),
    ],
)
def test_a_record_and_a_value_do_not_contradict_each_other(tmp_path: Path, columns: str, more: str, said: str) -> None:
    """The last one counted, and nothing was said."""
    (tmp_path / "motion.csv").write_text(f"{columns}\n0,0,1e-5\n1,2,3e-5\n", encoding="utf-8")
    done = evat("simulate", "-i", "motion.csv", *more.split(), folder=tmp_path, columns=1000)
    assert done.returncode != 0, done.stdout
    assert said in done.stderr
    assert [each.name for each in tmp_path.iterdir()] == ["motion.csv"]


def test_a_value_of_what_is_swept_over_is_refused_but_beside_the_grid(systems: dict[str, Path], tmp_path: Path) -> None:
    """It was hidden by the axis, and nothing was said."""
    over = "system", "sweep", str(systems["stick_slip"]), "--stop", "2 ms", "--over"
    for axis, value in (("guideway.F_C=1:2:2", "guideway.F_C=5"), ("guideway=lugre-1995,tribometer-5n", "guideway.sigma0=1 kN/m")):
        done = evat(*over, axis, "-v", value, folder=tmp_path, columns=1000)
        assert done.returncode == 2, done.stdout
        assert f"{value.partition('=')[0]} is swept over, as {axis.partition('=')[0]}; a value for it would change nothing." in done.stderr
        assert list(tmp_path.iterdir()) == []
    done = evat(*over, "guideway.F_C=1:2:2", "--beside", "guideway.F_C=5", folder=tmp_path, columns=1000)
    assert done.returncode == 0, done.stderr
