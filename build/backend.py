"""What has to be there while a wheel is built? hatchling, and what the package depends on, since it makes the FMUs in the wheel itself.

An editable install holds no FMU, and needs no more than hatchling says.
"""

from __future__ import annotations

import os
from typing import Any

from hatchling import build
from hatchling.build import build_editable, build_sdist, build_wheel, get_requires_for_build_editable, get_requires_for_build_sdist
from hatchling.builders.wheel import WheelBuilder

__all__ = [
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
]


def get_requires_for_build_wheel(config_settings: dict[str, Any] | None = None) -> list[str]:
    """As PEP 517 says."""
    return [*build.get_requires_for_build_wheel(config_settings), *WheelBuilder(os.getcwd()).metadata.core.dependencies]
