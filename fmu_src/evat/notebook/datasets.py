"""How do columns with units become an xarray Dataset or a pandas DataFrame?

Both libraries are loaded where one is asked for: nothing else here needs them, and they take longer to load than a run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

Coordinate = tuple[str, Any, str]  # dimension, values, unit


def plain(about: Mapping[str, Any]) -> dict[str, Any]:
    """Facts as attributes that every file format takes: what is nested becomes JSON."""
    return {
        name: value if isinstance(value, (str, int, float)) else json.dumps(value, sort_keys=True, default=str)
        for name, value in about.items()
    }


def dataset(
    columns: Mapping[str, Any],
    dimensions: Sequence[str],
    coordinates: Mapping[str, Coordinate],
    units: Mapping[str, str],
    about: Mapping[str, Any],
) -> Any:
    """An xarray.Dataset: each column over the first of the `dimensions` that its shape has; `units` in the attribute of that name."""
    import xarray

    data = {name: (tuple(dimensions)[: np.ndim(column)], column, _unit(units.get(name, ""))) for name, column in columns.items()}
    places = {name: (dimension, values, _unit(unit)) for name, (dimension, values, unit) in coordinates.items()}
    return xarray.Dataset(data, places, plain(about))


def _unit(unit: str) -> dict[str, str]:
    return {"units": unit} if unit else {}


def frame(times: Any, columns: Mapping[str, Any], units: Mapping[str, str], about: Mapping[str, Any]) -> Any:
    """A pandas.DataFrame over the time; `attrs["units"]` has the unit of each column, and of the index as "time"."""
    import pandas

    made = pandas.DataFrame(dict(columns), index=pandas.Index(times, name="time"))
    made.attrs = {**plain(about), "units": {"time": "s", **units}}
    return made
