"""Which vector instructions does this machine have? For choosing among libraries that give the same bits at different speeds."""

from __future__ import annotations

import functools
import importlib
from contextlib import suppress


@functools.lru_cache(maxsize=1)
def instructions() -> frozenset[str]:
    """Names such as AVX2, as numpy has found them (processor and operating system) for the choice of its own loops; none where a numpy
    keeps that elsewhere, which costs speed only."""
    for name in ("numpy._core._multiarray_umath", "numpy.core._multiarray_umath"):  # numpy 2, numpy 1
        with suppress(ModuleNotFoundError, AttributeError):
            return frozenset(feature for feature, there in importlib.import_module(name).__cpu_features__.items() if there)
    return frozenset()
