"""How does a result become JSON, which has no infinity and no tuple?"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any


def json_value(entry: Any) -> Any:
    """The same in dicts with texts as keys, lists and plain values; a float that is not finite is None."""
    if isinstance(entry, Mapping):
        return {str(key): json_value(value) for key, value in entry.items()}
    if isinstance(entry, (list, tuple)):
        return [json_value(value) for value in entry]
    return None if isinstance(entry, float) and not math.isfinite(entry) else entry
