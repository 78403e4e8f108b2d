"""Do systems run with parts from elsewhere, such as FMUs without units?"""

from __future__ import annotations

import io
import re
import zipfile
from pathlib import Path

import evat
import numpy as np
from evat.systems.ssp.read import read


def without_units(path: Path, component: str, to: Path) -> Path:
    """The system with no unit in that component's FMU, nor at its connectors."""
    with zipfile.ZipFile(path) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    structure = files["SystemStructure.ssd"].decode()
    (part,) = re.findall(rf'<ssd:Component name="{component}".*?</ssd:Component>', structure, re.DOTALL)
    source = re.search(r'source="([^"]*fmu)"', part)
    assert source is not None
    files["SystemStructure.ssd"] = structure.replace(part, re.sub(r' unit="[^"]*"', "", part)).encode()
    with zipfile.ZipFile(io.BytesIO(files[source[1]])) as packed:
        inner = {name: packed.read(name) for name in packed.namelist()}
    inner["modelDescription.xml"] = re.sub(rb' unit="[^"]*"', b"", inner["modelDescription.xml"])
    made = io.BytesIO()
    for target, content in ((made, inner), (to, {**files, source[1]: b""})):
        with zipfile.ZipFile(target, "w") as packed:
            for name, data in content.items():
                packed.writestr(name, made.getvalue() if name == source[1] and target is to else data)
    return to


def test_a_part_without_units_couples_with_a_note(systems: dict[str, Path], tmp_path: Path) -> None:
    bare = without_units(systems["stick_slip"], "guideway", tmp_path / "bare.ssp")
    system = read(bare, tmp_path / "in")
    assert any(re.match(r"guideway\.\w+ has no unit; it is taken to be in N, as drive\.\w+ is", note) for note in system.notes)
    assert not read(systems["stick_slip"], tmp_path / "own").notes
    asked = {"stop": "5 ms", "step": "1 ms"}
    ours, theirs = evat.run_system(systems["stick_slip"], **asked), evat.run_system(bare, **asked)  # type: ignore[arg-type]
    assert np.array_equal(ours["guideway.friction_force"], theirs["guideway.friction_force"])
    assert theirs.units["guideway.friction_force"] == "N"
    assert "has no unit" in str(theirs.made_by["notes"])
