"""What does a wheel hold beside the Python files? Kernel and FMUs compiled for this machine, the C sources for `evat build`, the guide."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


def load_alone(root: Path, file: str) -> ModuleType:
    """A file of fmu_src/evat without the package around it, whose dependencies are not installed while it is built."""
    spec = importlib.util.spec_from_file_location(f"evat_{Path(file).stem}", root / "fmu_src" / "evat" / file)
    if spec is None or spec.loader is None:
        raise FileNotFoundError(f"fmu_src/evat/{file} is missing in {root}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up by name
    spec.loader.exec_module(module)
    return module


def guide_included(root: Path) -> dict[str, str]:
    """The guide's pages, and the site if it was built from these very sources; without it `evat guide` says how it is built."""
    site = root / "build" / "out" / "guide"
    included = {str(root / "fmu_src" / "guide"): "evat/_source/guide"}
    if load_alone(root, "guide/seal.py").is_fresh(site, root / "fmu_src"):
        included[str(site)] = "evat/_guide"
    return included


def host_fmus(root: Path, folder: Path, version: str) -> list[Path]:
    """The FMUs for this machine and what says of each that it is whole, in `folder`: made by the package as it stands in `root`."""
    installed = folder / "site" / f"evat-{version}.dist-info"  # an FMU names the version of this wheel, and holds its licence
    installed.mkdir(parents=True)
    (installed / "METADATA").write_text(f"Metadata-Version: 2.1\nName: evat\nVersion: {version}\n", encoding="utf-8")
    shutil.copy(root / "LICENSE", installed)
    (installed / "RECORD").write_text(f"{installed.name}/LICENSE,,\n", encoding="utf-8")
    places = [str(root / "fmu_src"), str(folder / "site"), *filter(None, [os.environ.get("PYTHONPATH")])]
    command = [sys.executable, "-m", "evat.fmu.host", str(folder / "fmus")]
    try:
        subprocess.run(command, env={**os.environ, "PYTHONPATH": os.pathsep.join(places)}, check=True)
    except subprocess.CalledProcessError as error:
        raise RuntimeError(
            f"the FMUs in the wheel could not be made (status {error.returncode}); the message stands above. The package makes them: "
            "without build isolation, what it depends on has to be installed."
        ) from error
    return sorted((folder / "fmus").iterdir())


class WheelHook(BuildHookInterface[Any]):
    """Compiles what has changed: an editable install gets the libraries in the checkout, a wheel these and the FMUs, with the sources."""

    folder: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        root = Path(self.root)
        compile_c = load_alone(root, "native/compile.py")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{compile_c.host_target().wheel}"
        libraries = compile_c.build_libraries(root / "fmu_src" / "evat" / "_lib")
        if version == "editable":
            return
        self.folder = tempfile.TemporaryDirectory(prefix="evat-wheel-")
        included = build_data["force_include"]
        for library in libraries:
            for path in (library, compile_c.seal_of(library)):
                included[str(path)] = f"evat/_lib/{path.name}"
        for path in host_fmus(root, Path(self.folder.name), self.metadata.version):
            included[str(path)] = f"evat/_fmus/{path.name}"
        for part in ("kernel", "machines", "fmi", "fmus", "coupling"):
            included[str(root / "fmu_src" / part)] = f"evat/_source/{part}"
        included[str(root / "ssp")] = "evat/_source/ssp"
        included.update(guide_included(root))

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if self.folder is not None:
            self.folder.cleanup()
