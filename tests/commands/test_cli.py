"""Does each command do what its help says, and answer a mistake with one clear line?"""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
from command_line import evat
from evat import parameter_sets
from evat.commands import main
from evat.commands.main import app
from evat.files.table import read_table
from evat.models.simulate import NO_WINDOW
from evat.native.compile import source_root
from typer.testing import CliRunner


def test_simulate_writes_a_table_and_a_picture(tmp_path: Path) -> None:
    done = evat(
        *("simulate", "-s", "regularised/al-7075-t6", "--law", "lugre", "-v", "cutting_speed=20 m/min", "-v", "feed=50um"),
        *("--principle", "minimum_energy", "-o", "cut.parquet"),
        folder=tmp_path,
    )
    assert done.returncode == 0, done.stderr
    table = read_table(tmp_path / "cut.parquet")
    times = table.clock("time [s]")
    assert times[-1] == pytest.approx(5 / 20e3)  # five cycles of 20 kHz
    thickness = table.column("uncut_thickness_used [m]", "m")
    assert 45e-6 < thickness.max() <= 50e-6 * (1 + 1e-9)  # never above the feed
    assert (tmp_path / "cut.png").stat().st_size > 10_000
    made_by = pyarrow.parquet.read_table(tmp_path / "cut.parquet").schema.metadata[b"made_by"]
    assert b"thermal_softening" in made_by
    assert b"cutting_speed" in made_by


def test_simulate_follows_a_file_of_slip(tmp_path: Path) -> None:
    times = np.linspace(0, 1, 101)
    rows = "\n".join(f"{t:.6g},{50 * np.sin(2 * np.pi * t):.6g}" for t in times)
    (tmp_path / "motion.csv").write_text(f"time [s],slip_velocity [mm/s]\n{rows}\n", encoding="utf-8")
    done = evat("simulate", "-i", "motion.csv", "--law", "coulomb", "-v", "F_C=3", "-o", "out.csv", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    force = read_table(tmp_path / "out.csv").column("friction_force [N]", "N")
    assert force[25] == pytest.approx(3)
    assert force[75] == pytest.approx(-3)


def test_a_window_that_counts_as_none_is_that_of_the_kernel() -> None:
    (length,) = re.findall(r"#define NO_WINDOW (\S+)", (source_root() / "kernel" / "stages.h").read_text(encoding="utf-8"))
    assert float(length) == NO_WINDOW


@pytest.mark.parametrize(
    ("more", "ended"),
    [
        ("--cycles 0.5", False),
        ("--cycles 0.5 -v averaging_window=60us", False),
        ("--cycles 1", True),
        ("--cycles 0.5 -v averaging_window=20us", True),
        ("--cycles 0.5 -v averaging=cycle", True),
        ("-i motion.csv --law coulomb", True),
        ("-i motion.csv --law coulomb -v averaging_window=2", False),
    ],
)
def test_a_mean_of_no_window_is_none(tmp_path: Path, more: str, ended: bool) -> None:
    """It was 0 N, which is what a contact in the air gives."""
    (tmp_path / "motion.csv").write_text("time [s],slip_velocity [mm/s]\n0,1\n1,1\n", encoding="utf-8")
    told = evat("simulate", *more.split(), "-o", "out.csv", folder=tmp_path, columns=1000)
    assert told.returncode == 0, told.stderr
    assert ("mean over the last window" in told.stdout) == ended
    assert ("no averaging window has ended within " in told.stdout) != ended
    means = json.loads(evat("simulate", *more.split(), "-o", "out.csv", "--json", folder=tmp_path).stdout)["mean"]
    forces = [means[name]["value"] for name in ("mean_friction_force", "mean_principal_force")]
    assert [force is not None and force != 0 for force in forces] == [ended] * 2
    assert (means["mean_contact_ratio"]["value"] is None) != ended


def test_without_a_command_they_are_listed(tmp_path: Path) -> None:
    listed = evat(folder=tmp_path)
    assert listed.returncode == 2
    assert listed.stdout == evat("-h", folder=tmp_path).stdout


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("simulate", "-v", "cutting_sped=1"), "did you mean cutting_speed"),
        (("simulate", "-v", "cutting_speed=1 kg"), "kg"),
        (("simulate", "-v", "F_C=-1"), "allowed is"),
        (("simulate", "--law", "stribeck"), "coulomb, lugre, dahl"),
        (("simulate", "-s", "regularised/wood"), "no parameter set"),
        (("simulate", "-e", "magic"), "thermal_softening"),
        (("simulate", "-v", "principal_force=1"), "cannot be set"),
        (("simulate", "-i", "nowhere.csv"), "nowhere.csv"),
        (("sets", "published/inconel-718", "--strict"), "11.6 m/min"),
        (("info", "sigma9"), "sigma0"),
        (("experiment", "orthogonal", "-s", "published/copper", "--repeats", "1000000000", "--out", "rig"), "1 to 1000 trials"),
    ],
)
def test_a_mistake_is_one_clear_line(tmp_path: Path, arguments: tuple[str, ...], what: str) -> None:
    done = evat(*arguments, folder=tmp_path)
    assert done.returncode == 2
    assert what in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_sets_and_info_list_what_there_is(tmp_path: Path) -> None:
    listed = evat("sets", folder=tmp_path).stdout
    for name in parameter_sets.names():
        assert name in listed
    about = " ".join(evat("info", "thermal_softening", folder=tmp_path).stdout.split())
    assert "k_Q" in about
    assert "the paper" in about


def test_a_saved_set_is_simulated_like_the_shipped_one(tmp_path: Path) -> None:
    assert evat("sets", "regularised/copper", "--save", "copper.ssv", folder=tmp_path).returncode == 0
    for name, output in (("copper.ssv", "a.csv"), ("regularised/copper", "b.csv")):
        assert evat("simulate", "-s", name, "-o", output, folder=tmp_path).returncode == 0
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_help_comes_before_anything_heavy_is_loaded() -> None:
    """It takes a tenth of a second, nearly all of it typer's; drawn by rich it took a quarter, numpy alone takes as long. Of ours it needs
    next to nothing."""
    code = "import sys; sys.argv = ['evat', '--help']; import atexit; atexit.register(lambda: print('loaded', *sys.modules))\n"
    code += "from evat.commands.main import main; main()"
    printed = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout
    shown, loaded = printed.rsplit("loaded ", 1)
    assert "simulate" in shown
    assert all(text in " ".join(shown.split()) for _, text in main.COMMANDS.values())
    assert not {"numpy", "lxml", "cffi", "pint", "importlib.metadata", "rich.markdown", "pygments"} & set(loaded.split())
    own = {"evat", "evat.commands", "evat.commands.main", "evat.commands.statuses", "evat.console", "evat.headline"}
    assert {name for name in loaded.split() if name.partition(".")[0] == "evat"} == own


def test_a_diagnosis_loads_only_what_it_uses(tmp_path: Path) -> None:
    """As far as there is an experiment to read; what runs the FMU is loaded where it runs."""
    code = "import sys; import atexit; atexit.register(lambda: print('loaded', *sys.modules))\n"
    code += "sys.argv = ['evat', 'diagnose', 'nowhere', '--no-fmu']; from evat.commands.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "nowhere" in done.stderr
    loaded = set(done.stdout.rsplit("loaded ", 1)[1].split())
    assert "evat.gap" in loaded
    assert not {"fmpy", "pythonfmu", "pymoo", "cma", "distributed", "xarray", "SALib", "tomlkit", "mkdocs"} & loaded
    rooms = {name.split(".")[1] for name in loaded if name.startswith("evat.")}
    assert not rooms & {"fmu", "guide", "identification", "processes", "signature", "studies", "systems"}
    assert not {"evat.paper.conditions", "evat.paper.work_materials"} & loaded
    assert {name for name in loaded if name.startswith("evat.commands.")} == {
        "evat.commands.diagnose", "evat.commands.main", "evat.commands.shared", "evat.commands.statuses", "evat.commands.tables",
    }  # fmt: skip


@pytest.mark.parametrize("name", main.COMMANDS)
def test_the_list_of_commands_says_what_each_says_of_itself(name: str) -> None:
    command = main.loaded(name)
    assert command.name == name
    assert " ".join(command.help.split("\n\n")[0].split()) == main.COMMANDS[name][1]


@pytest.mark.parametrize("command", [[], ["simulate"], ["experiment", "check"], ["system", "run"]])
def test_h_is_help(command: list[str]) -> None:
    short, long = (CliRunner().invoke(app, [*command, flag]) for flag in ("-h", "--help"))
    assert (short.exit_code, short.output) == (0, long.output)
    assert "Usage:" in short.output


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("build", r"--out\W+-o"),
        ("effects", r"The picture goes to NAME.png in the present folder"),
        ("system run", r"They go to system.csv, system.png and system.html in the present folder"),
    ],
)
def test_help_says_where_files_go(tmp_path: Path, command: str, said: str) -> None:
    assert re.search(said, evat(*command.split(), "--help", folder=tmp_path, columns=200).stdout)
