"""Does `evat effects` tell all about every effect in a terminal of 100 columns, as JSON and as a picture?"""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import command_line
import pytest
from evat.native import kernel
from matplotlib.image import imread


def evat(*arguments: str, folder: Path, columns: int = 100) -> subprocess.CompletedProcess[str]:
    return command_line.evat("effects", *arguments, folder=folder, columns=columns)


def test_the_list_tells_all_within_100_columns(tmp_path: Path) -> None:
    done = evat(folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert max(map(len, done.stdout.splitlines())) <= 100
    text = " ".join(done.stdout.split())
    for effect in kernel.effects():
        for fact in (effect.equation, effect.signature, effect.source, f"stage: {effect.stage}", *effect.needs, *effect.rivals):
            assert " ".join(fact.split()) in text, (effect.name, fact)
        entry = done.stdout.split(f"\n  {effect.name} ")[1].split("neutral")[1]
        for variable in effect.variables:
            assert variable.name.partition(".")[2] in entry.split(), variable.name
    assert list(tmp_path.iterdir()) == []


def test_json_holds_what_the_kernel_says_in_si(tmp_path: Path) -> None:
    entries = json.loads(evat("--json", folder=tmp_path).stdout)
    assert [entry["name"] for entry in entries] == [effect.name for effect in kernel.effects()]
    for entry, effect in zip(entries, kernel.effects(), strict=True):
        assert (entry["stage"], entry["rivals"], entry["needs"]) == (effect.stage, list(effect.rivals), list(effect.needs))
        for told, variable in zip(entry["variables"], effect.variables, strict=True):
            assert (told["name"], told["unit"], told["start"], told["source"]) == (
                variable.name,
                variable.unit,
                variable.start,
                variable.source,
            )
            assert told["neutral"] == (variable.neutral if variable.neutral == variable.neutral else None)
    assert json.loads(evat("run_out", "--json", folder=tmp_path).stdout) == [entry for entry in entries if entry["name"] == "run_out"]
    assert list(tmp_path.iterdir()) == []


def test_one_effect_is_told_in_full_and_drawn(tmp_path: Path) -> None:
    done = evat("run_out", "-v", "run_out.amplitude=20um", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    told = " ".join(done.stdout.split())
    assert "turns of the spindle per time" in told
    assert "0 um .. 1000 um" in told
    assert "wrote run_out.png" in told
    picture = imread(tmp_path / "run_out.png")
    assert picture.shape[0] > 800
    assert picture.shape[1] > 1200
    assert 0.02 < (picture[..., :3].min(axis=2) < 0.9).mean() < 0.3  # lines and letters, neither blank nor full


def test_a_set_and_values_are_shown_too(tmp_path: Path) -> None:
    done = evat("direction_asymmetry", "-s", "tribometer-5n", "-o", "pictures/a.png", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    nominal = evat("direction_asymmetry", "-o", "pictures/b.png", folder=tmp_path)
    assert nominal.returncode == 0, nominal.stderr
    assert (tmp_path / "pictures" / "a.png").read_bytes() != (tmp_path / "pictures" / "b.png").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("sensr_delay",), "did you mean sensor_delay"),
        (("xyzzy",), "`evat effects` lists them all"),
        (("run_out", "-v", "run_out.amplitude=20kg"), "kg"),
        (("run_out", "-s", "regularised/wood"), "no parameter set"),
        (("thermal_damping", "-v", "proxy_source=contact_temperature"), "contact_temperature"),
    ],
)
def test_a_mistake_is_one_clear_line(tmp_path: Path, arguments: tuple[str, ...], what: str) -> None:
    done = evat(*arguments, folder=tmp_path, columns=1000)
    assert done.returncode == 2
    assert what in done.stderr
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []
