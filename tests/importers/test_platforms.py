"""Do the libraries for other systems compute what that of this machine does? Windows' in wine, those for ARM in qemu.

On Debian: apt install wine64 qemu-user-static libc6-arm64-cross.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from evat.fmu import build_fmu
from evat.native.compile import TARGETS, Target, fmi_headers, host_target

HOST = Path(__file__).with_name("host_platform.c")
ARM_ROOT = Path("/usr/aarch64-linux-gnu")  # where Debian's libc6-arm64-cross puts it
WINE = shutil.which("wine64") or shutil.which("wine64", path="/usr/lib/wine")
QEMU = shutil.which("qemu-aarch64-static") or shutil.which("qemu-aarch64")
RUNNERS = {
    "x86_64-windows": [WINE] if WINE else None,
    "aarch64-linux": [QEMU, "-L", str(ARM_ROOT)] if QEMU and (ARM_ROOT / "lib" / "ld-linux-aarch64.so.1").exists() else None,
}
OUTPUTS = ("friction_force", "principal_force", "feed_force", "slip_velocity_used", "uncut_thickness_used", "bristle_deflection")
STEP, COUNT = 1e-6, 200  # four cycles of the ellipse, entries and exits among them


def hosted(target: Target, folder: Path) -> Path:
    """The host for a system."""
    made = folder / ("host.exe" if target.system == "windows" else "host")
    link = [] if target.system == "windows" else ["-ldl"]
    include = f"-I{fmi_headers()}"
    subprocess.run([sys.executable, "-m", "ziglang", "cc", "-target", target.zig, include, str(HOST), "-o", str(made), *link], check=True)
    return made


@pytest.mark.campaign
@pytest.mark.parametrize("key", RUNNERS)
def test_an_ellipse_is_that_of_this_machine(key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    runner, target = RUNNERS[key], TARGETS[key]
    if runner is None:
        pytest.skip(f"nothing here runs {key}; on Debian: apt install wine64 qemu-user-static libc6-arm64-cross")
    monkeypatch.setenv("WINEPREFIX", str(tmp_path / "wine"))
    monkeypatch.setenv("WINEDEBUG", "-all")
    fmu = build_fmu(2, tmp_path / "cut.fmu", {key, host_target().fmi3_folder}, part="evat_cut")
    description = fmpy.read_model_description(str(fmu))
    with zipfile.ZipFile(fmu) as archive:
        name = f"{description.coSimulation.modelIdentifier}{target.extension}"
        library = archive.extract(f"binaries/{target.fmi2_folder}/{name}", tmp_path)
    references = {variable.name: str(variable.valueReference) for variable in description.modelVariables}
    asked = [str(hosted(target, tmp_path)), library, description.guid, repr(STEP), str(COUNT), *(references[name] for name in OUTPUTS)]
    answer = subprocess.run([*runner, *asked], capture_output=True, text=True, check=False, timeout=300)
    assert answer.returncode == 0, answer.stderr[-2000:]
    there = np.array([[float(number) for number in line.split()] for line in answer.stdout.splitlines()])
    here = fmpy.simulate_fmu(
        str(fmu), fmi_type="CoSimulation", stop_time=COUNT * STEP, step_size=STEP, output_interval=STEP, output=list(OUTPUTS)
    )
    assert there.shape == (COUNT, 1 + len(OUTPUTS))
    for place, name in enumerate(OUTPUTS):
        assert np.ptp(here[name]) > 0
        assert there[:, 1 + place] == pytest.approx(here[name][1:], abs=1e-9 * float(np.max(np.abs(here[name])))), name
