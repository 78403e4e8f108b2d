"""Which parameter sets are there, and what is in one? Values in SI with their sources, shipped (TOML) or a user's (.ssv or .toml).

Examples
--------
>>> import evat
>>> evat.parameter_sets.names()[0]
'lugre-1995'
>>> copper = evat.parameter_sets.load("published/copper")
>>> print(f"F_C = {copper.values['F_C']:g} N: {copper.sources['F_C']}")  # doctest: +ELLIPSIS
F_C = 0.1127 N: ...table 1, F_C of copper
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Any

from evat.files import ssv
from evat.files.read_toml import TomlError, read_toml
from evat.model import ParameterError, near_names
from evat.native import kernel
from evat.paper.tables import materials, table_1, table_1_source
from evat.units import SPEED_UNITS, display, to_si

FOLDER = Path(__file__).resolve().parent / "parameters"
KEYS = ("title", "source", "base", "effects", "notes", "speed_range", "values")
SHIPPED_KEYS = (*KEYS, "table")
ENTRY_KEYS = ("value", "unit", "source")


@dataclass(frozen=True, slots=True)
class ParameterSet:
    """Values of the component (SI; a choice by its place) with where each comes from.

    `effects` are on, the others off. `speed_range` [m/s] is where the set claims to hold, None where it claims nothing.
    """

    name: str
    title: str
    values: Mapping[str, float]
    effects: tuple[str, ...] = ()
    sources: Mapping[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    speed_range: tuple[float, float] | None = None

    @property
    def by_choice(self) -> dict[str, float | str | bool]:
        """The values with choices by their names and switches as yes or no: what FMUs and people take."""
        return kernel.by_choice(self.values)


def names() -> tuple[str, ...]:
    """The shipped sets.

    Returns
    -------
    tuple of str
        Names, such as "regularised/copper".

    Raises
    ------
    ParameterError
        Where a shipped file is damaged.

    Examples
    --------
    >>> import evat
    >>> "regularised/inconel-718" in evat.parameter_sets.names()
    True
    """
    shipped: list[str] = []
    for path in sorted(FOLDER.glob("*.toml")):
        shipped += [f"{path.stem}/{material}" for material in materials()] if _is_family(path.stem) else [path.stem]
    return tuple(shipped)


def load(name_or_path: str | PathLike[str], *, speed_unit: str = "m/min", strict: bool = False) -> ParameterSet:
    """A shipped set by its name, or a user's .ssv or .toml file.

    Parameters
    ----------
    name_or_path : str or path
        One of `names()`, or a file.
    speed_unit : "m/min" or "m/s"
        The unit that the paper's coefficients are read in; only for sets that rest on its table 1, which states none.
    strict : bool
        Refuse a set that breaks the paper's eq. 7 within its speed range.

    Returns
    -------
    ParameterSet
        `values` (SI), `effects` that are on, `sources` of each value, `notes`, `speed_range` [m/s].

    Raises
    ------
    ParameterError
        Where there is no such set or file, or it holds what the component does not allow.

    Examples
    --------
    >>> import evat
    >>> evat.parameter_sets.load("regularised/copper").effects
    ('thermal_softening', 'thermal_damping')
    """
    if speed_unit not in SPEED_UNITS:
        raise ParameterError(f"speed unit {speed_unit!r}: allowed is {' or '.join(SPEED_UNITS)}.")
    name, path = str(name_or_path), Path(name_or_path)
    if name in names():
        family, _, material = name.partition("/")
        parameter_set = _from_toml(FOLDER / f"{family}.toml", name, material or None, speed_unit)
    elif path.suffix in (".ssv", ".toml"):
        if not path.is_file():
            raise ParameterError(f"parameter set {name}: there is no such file.")
        parameter_set = load_ssv(path) if path.suffix == ".ssv" else _from_toml(path, path.stem, None, speed_unit)
    else:
        near = near_names(name, names())
        hint = f"did you mean {', '.join(near)}? " if near else ""
        raise ParameterError(f"there is no parameter set {name!r}; {hint}shipped are {', '.join(names())}; or give an .ssv or .toml file.")
    if strict:
        check_stiffness(parameter_set)
    return parameter_set


def load_ssv(path: str | PathLike[str]) -> ParameterSet:
    """A set from an SSP parameter values file.

    Parameters
    ----------
    path : path
        The .ssv file.

    Returns
    -------
    ParameterSet
        Values in SI, whatever the units of the file.

    Raises
    ------
    ParameterError
        Where the file cannot be read, or holds what the component does not allow.

    Examples
    --------
    >>> import evat
    >>> path = evat.parameter_sets.save_ssv(evat.parameter_sets.load("lugre-1995"), "lugre.ssv")
    >>> evat.parameter_sets.load_ssv(path).values["sigma0"]  # N/m
    100000.0
    """
    content = ssv.read(Path(path), kernel.by_name())
    switches = [effect.name for effect in kernel.effects()]
    return ParameterSet(
        name=content.name,
        title=content.title,
        values={name: value for name, value in content.values.items() if name not in switches},
        effects=tuple(name for name in switches if content.values.get(name)),
        sources=content.sources,
        notes=content.notes,
        speed_range=content.speed_range,
    )


def save_ssv(parameter_set: ParameterSet, path: str | PathLike[str]) -> Path:
    """Write a set as an SSP 1.0 parameter values file, units and sources included; the file appears whole or not at all.

    Parameters
    ----------
    parameter_set : ParameterSet
        What to write.
    path : path
        The .ssv file.

    Returns
    -------
    Path
        Of the file.

    Raises
    ------
    ParameterError
        For a value that the component does not allow.
    OutputError
        Where the file cannot be written.

    Examples
    --------
    >>> import evat
    >>> evat.parameter_sets.save_ssv(evat.parameter_sets.load("regularised/copper"), "copper.ssv").name
    'copper.ssv'
    """
    values = kernel.check_values(parameter_set.values, parameter_set.effects)
    content = ssv.Content(
        parameter_set.name, parameter_set.title, values, dict(parameter_set.sources), parameter_set.notes, parameter_set.speed_range
    )
    return ssv.write(Path(path), content, kernel.by_name())


def of_component(values: Mapping[str, float | str]) -> tuple[dict[str, float], dict[str, float | str]]:
    """Tell values of the component from those of whatever else it stands in.

    Parameters
    ----------
    values : mapping of str to float or str
        By their names: numbers are SI, texts may have a unit, choices go by name.

    Returns
    -------
    tuple of dict and dict
        The component's, as the numbers that a `ParameterSet` holds, without switches of effects; and the others, as they were.

    Raises
    ------
    ParameterError
        For a value that the component does not allow.

    Examples
    --------
    >>> import evat
    >>> evat.parameter_sets.of_component({"F_C": 8.0, "mass": 95.0})
    ({'F_C': 8.0}, {'mass': 95.0})
    """
    switches = {effect.name for effect in kernel.effects()}
    others = {name: value for name, value in values.items() if name not in kernel.by_name()}
    numbers = kernel.check_values({name: value for name, value in values.items() if name not in others})
    return {name: number for name, number in numbers.items() if name not in switches}, others


def softening_limit(values: Mapping[str, float]) -> float:
    """The proxy speed [m/s] at which the paper's eq. 7, P > k_Q (theta/theta_ref)^Q, stops to hold."""
    P, k_Q, Q = (_value(values, name) for name in ("sigma0", "thermal_softening.k_Q", "thermal_softening.Q"))
    if k_Q <= 0:
        return math.inf
    if Q == 0:
        return math.inf if k_Q < P else 0.0
    try:
        return float(_value(values, "theta_ref") * (P / k_Q) ** (1 / Q))
    except OverflowError:
        return math.inf


def check_stiffness(parameter_set: ParameterSet) -> None:
    """ParameterError where softening leaves no stiffness within the speed range of the set (the paper, eq. 7)."""
    if "thermal_softening" not in parameter_set.effects:
        return
    if parameter_set.speed_range is None:
        raise ParameterError(
            f"{parameter_set.name}: no speed range is declared, so the paper's eq. 7 cannot be checked; load it without strict."
        )
    limit = softening_limit(parameter_set.values)
    low, high = parameter_set.speed_range
    if limit <= high:
        bound, lowest, highest = (display(speed, kernel.variable("theta_ref"), digits=3) for speed in (limit, low, high))
        raise ParameterError(
            f"{parameter_set.name}: thermal softening leaves no stiffness from {bound} ({limit:.3g} m/s) up (the paper, eq. 7: P > v^Q); "
            f"the set declares {lowest} to {highest}. Stay below that speed, turn thermal_softening off, or load it without strict: "
            "s0 is then clamped and counted."
        )


def _value(values: Mapping[str, float], name: str) -> float:
    return values[name] if name in values else kernel.variable(name).start


def _is_family(stem: str) -> bool:
    document = _document(FOLDER / f"{stem}.toml", SHIPPED_KEYS)
    return "table" in document or ("base" in document and _is_family(document["base"]))


def _document(path: Path, allowed: tuple[str, ...]) -> dict[str, Any]:
    try:
        document = read_toml(path)
    except TomlError as error:
        raise ParameterError(str(error)) from error
    for key in document:
        if key not in allowed:
            raise ParameterError(f"{path.name}, key {key!r}: not known; allowed are {', '.join(allowed)}.")
    return document


def _from_toml(path: Path, name: str, material: str | None, speed_unit: str) -> ParameterSet:
    """The set of a file: what it is based on, the paper's column if it is of a family, then its own values."""
    document = _document(path, KEYS if material is None else SHIPPED_KEYS)
    base = ParameterSet(name, name, {})
    if "base" in document:
        base_name = f"{document['base']}/{material}" if material else str(document["base"])
        if base_name not in names():
            raise ParameterError(f"{path.name}, key 'base': {base_name!r} is no shipped set; allowed are {', '.join(names())}.")
        base = load(base_name, speed_unit=speed_unit)
    elif material is None and speed_unit != SPEED_UNITS[0]:
        raise ParameterError(f"{name} states its units; speed unit {speed_unit!r} is only for sets that rest on the paper's table 1.")
    values, sources = dict(base.values), dict(base.sources)
    if "table" in document:
        for cell in table_1(str(material)):
            variable = kernel.variable(cell.variable)
            values[cell.variable] = variable.check(
                to_si(f"{cell.printed!r} {_spelled(cell.unit, speed_unit)}", variable.unit, name=cell.row)
            )
            inferred = f", speed unit {speed_unit} inferred" if "speed" in cell.unit else ""
            sources[cell.variable] = f"{table_1_source()}, {cell.row} of {materials()[str(material)]}{inferred}"
    for key, entry in _table(path, "values", document.get("values", {})).items():
        values[key] = _entry_value(path, key, entry, speed_unit)
        sources[key] = str(entry.get("source", document.get("source", "guess")))
    effects = _texts(path, "effects", document.get("effects", base.effects))
    for effect in effects:
        if effect not in {known.name for known in kernel.effects()}:
            raise ParameterError(f"{path.name}, key 'effects': there is no effect {effect!r}.")
    speed_range = _speed_range(path, document["speed_range"]) if "speed_range" in document else base.speed_range
    title, notes = str(document.get("title", name)), _texts(path, "notes", document.get("notes", base.notes))
    if material is not None:
        facts = _facts(values, speed_range, speed_unit) | {"material": materials()[material]}
        title, notes = title.format(**facts), tuple(note.format(**facts) for note in notes)
    return ParameterSet(name, title, values, effects, sources, notes, speed_range)


def _table(path: Path, key: str, entry: Any) -> dict[str, Any]:
    if not isinstance(entry, dict):
        raise ParameterError(f"{path.name}, key {key!r}: {entry!r}; a table is needed, with {', '.join(ENTRY_KEYS)}.")
    return entry


def _texts(path: Path, key: str, entry: Any) -> tuple[str, ...]:
    if not isinstance(entry, (list, tuple)) or not all(isinstance(text, str) for text in entry):
        raise ParameterError(f"{path.name}, key {key!r}: {entry!r}; a list of texts is needed, [] where there are none.")
    return tuple(entry)


def _entry_value(path: Path, key: str, entry: Any, speed_unit: str) -> float:
    """A [values.key] table as the number that the component holds."""
    for part in _table(path, key, entry):
        if part not in ENTRY_KEYS:
            raise ParameterError(f"{path.name}, key {key}.{part}: not known; allowed are {', '.join(ENTRY_KEYS)}.")
    try:
        variable = kernel.variable(key)
        if variable.causality not in ssv.SETTABLE:
            raise ParameterError(f"{key} is an {variable.causality}; a set holds parameters and inputs.")
        if "value" not in entry:
            raise ParameterError(f"{key}: the value is missing.")
        value = entry["value"]
        if variable.type != "real":
            return variable.check(value)
        if isinstance(value, (bool, str, list, dict)) or ("unit" not in entry and variable.unit != "1"):
            raise ParameterError(f"{key} = {value!r}: a number and its unit are needed, such as {variable.unit}.")
        return variable.check(to_si(f"{value!r} {_spelled(str(entry.get('unit', '1')), speed_unit)}", variable.unit, name=key))
    except (ParameterError, TypeError) as error:
        raise ParameterError(f"{path.name}: {error}") from error


def _spelled(unit: str, speed_unit: str) -> str:
    """The unit with the open unit of speed filled in; no unit for "1"."""
    return "" if unit == "1" else re.sub(r"\bspeed\b", f"({speed_unit})", unit)


def _speed_range(path: Path, entry: Any) -> tuple[float, float]:
    bounds = _table(path, "speed_range", entry).get("value")
    if not (isinstance(bounds, list) and len(bounds) == 2 and "unit" in entry):
        raise ParameterError(f"{path.name}, key 'speed_range': value = [lowest, highest] and a unit are needed.")
    low, high = (to_si(f"{bound!r} {entry['unit']}", "m/s", name="speed_range") for bound in bounds)
    if not 0 <= low < high:
        raise ParameterError(
            f"{path.name}, key 'speed_range': {bounds} {entry['unit']}; a speed is at least 0 and the second is the higher."
        )
    return low, high


def _facts(values: Mapping[str, float], speed_range: tuple[float, float] | None, speed_unit: str) -> dict[str, str]:
    """Numbers that a note of a family may quote."""
    limit = softening_limit(values)
    where = "inside" if speed_range and limit <= speed_range[1] else "beyond"
    v = 0.5
    g = values["F_C"] + (values["F_S"] - values["F_C"]) * math.exp(-((v / values["v_s"]) ** 2))
    s1 = values["sigma1"] * (v / values["theta_ref"]) ** values["thermal_damping.alpha2"]
    in_unit = limit / values["theta_ref"]
    return {
        "speed_unit": speed_unit,
        "eq_7": f"eq. 7 of the paper, P > v^Q, stops to hold at {in_unit:.3g} {speed_unit}, {where} the speed range of this set",
        "damping_ratio": f"{v * s1 / (4 * g):.2g}",
    }
