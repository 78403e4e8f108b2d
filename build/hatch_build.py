"""What does a wheel hold beside the Python files? The kernel compiled for this machine, the C sources for `evat build`, the guide."""

from __future__ import annotations

import importlib.util
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


class KernelHook(BuildHookInterface[Any]):
    """Compiles the kernel: an editable install gets it in the checkout, a wheel in evat/_lib with the sources in evat/_source."""

    folder: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        root = Path(self.root)
        compile_c = load_alone(root, "native/compile.py")
        build_data["pure_python"] = False
        build_data["tag"] = f"py3-none-{compile_c.host_target().wheel}"
        if version == "editable":
            compile_c.build_libraries(root / "fmu_src" / "evat" / "_lib")
            return
        self.folder = tempfile.TemporaryDirectory(prefix="evat-kernel-")
        included = build_data["force_include"]
        for library in compile_c.build_libraries(Path(self.folder.name)):
            for path in (library, compile_c.seal_of(library)):
                included[str(path)] = f"evat/_lib/{path.name}"
        for part in ("kernel", "machines", "fmi", "fmus", "coupling"):
            included[str(root / "fmu_src" / part)] = f"evat/_source/{part}"
        included[str(root / "ssp")] = "evat/_source/ssp"
        included.update(guide_included(root))

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        if self.folder is not None:
            self.folder.cleanup()
