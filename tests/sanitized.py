"""The kernel compiled for the sanitizers, once for all tests that ask for it: that takes longer than most of what it is asked for."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from evat.native.compile import compile_library, fmi_headers, host_target, include_folders, kernel_sources, source_root
from filelock import FileLock


def kernel_objects(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Its objects by their names, in a folder that all workers share."""
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    root, folder = source_root(), base / "sanitized-kernel"
    with FileLock(base / "sanitized-kernel.lock"):
        if not folder.is_dir():
            include = [*include_folders(root), fmi_headers()]
            compile_library(kernel_sources(root), folder, host_target(), include=include, exports=["kernel.h"], link=False, sanitize=True)
    return {path.name: path for path in folder.glob("*.o")}
