"""Which output depends on what? FMI's ModelStructure, found by asking the kernel (probe.py) instead of declaring it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from evat.fmu.structure.probe import Probe
from evat.fmu.structure.structure_cache import keep, key_of, place_of, recall
from evat.model import Variable
from evat.native import kernel
from evat.native.compile import kernel_library_path


@dataclass(frozen=True, slots=True)
class Unknown:
    """An unknown with the knowns that it follows, and how each enters (FMI's dependenciesKind)."""

    variable: Variable
    knowns: tuple[Variable, ...]
    kinds: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Structure:
    """FMI's ModelStructure, the states that an event may set, and the number of event indicators."""

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial_unknowns: tuple[Unknown, ...]
    indicators: tuple[Unknown, ...]
    reinit: frozenset[str]


def restricted(structure: Structure, variables: Sequence[Variable]) -> Structure:
    """What is left of it where there are these variables alone, and everything else stands still."""
    there = {v.name: v for v in variables}

    def kept(unknowns: Sequence[Unknown]) -> tuple[Unknown, ...]:
        rows = []
        for unknown in unknowns:
            if unknown.variable.name in there:
                pairs = [(there[v.name], kind) for v, kind in zip(unknown.knowns, unknown.kinds, strict=True) if v.name in there]
                rows.append(Unknown(there[unknown.variable.name], tuple(v for v, _ in pairs), tuple(kind for _, kind in pairs)))
        return tuple(rows)

    return Structure(
        outputs=tuple(unknown for unknown in kept(structure.outputs) if unknown.variable.causality == "output"),
        derivatives=tuple(unknown for unknown in kept(structure.derivatives) if unknown.variable.derivative_of),
        initial_unknowns=kept([u for u in structure.initial_unknowns if (v := there.get(u.variable.name)) and _is_asked_for(v)]),
        indicators=kept(structure.indicators),
        reinit=structure.reinit & there.keys(),
    )


def _is_asked_for(variable: Variable) -> bool:
    """FMI asks for the start of outputs and of rates."""
    return variable.causality == "output" or variable.derivative_of is not None


def _running(probe: Probe, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
    """The unknowns with their knowns in the order of the table; a state that is an output follows itself alone."""
    rows = []
    for unknown in unknowns:
        if unknown in probe.states:
            rows.append(Unknown(unknown, (unknown,), ("constant",)))
            continue
        row = probe.unknowns.index(unknown)
        places = _in_order(probe.driven, probe.factors.seen[row])
        kinds = tuple(probe.factors.kind(row, place) for place in places)
        rows.append(Unknown(unknown, tuple(probe.driven[place] for place in places), kinds))
    return tuple(rows)


def _initial(probe: Probe, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
    """The same for the initialisation, where no kind but the general one is told."""
    rows = []
    for unknown in unknowns:
        knowns = sorted(probe.initial_knowns(unknown), key=lambda v: v.index)
        rows.append(Unknown(unknown, tuple(knowns), ("dependent",) * len(knowns)))
    return tuple(rows)


def _in_order(knowns: Sequence[Variable], chosen: npt.NDArray[np.bool_]) -> list[int]:
    return sorted(np.flatnonzero(chosen).tolist(), key=lambda place: knowns[place].index)


def find_structure() -> Structure:
    """Ask the kernel; a minute."""
    probe = Probe()
    probe.search()
    late = sorted({*probe.outputs, *probe.rates}, key=lambda v: v.index)
    return Structure(
        outputs=_running(probe, [v for v in kernel.variables() if v.causality == "output"]),
        derivatives=_running(probe, probe.rates),
        initial_unknowns=_initial(probe, late),
        indicators=_running(probe, probe.indicators),
        reinit=frozenset(state.name for state, is_set in zip(probe.states, probe.reinit, strict=True) if is_set),
    )


_PARTS = ("outputs", "derivatives", "initial_unknowns", "indicators")


def as_names(structure: Structure) -> dict[str, Any]:
    """The structure as plain names, for a file."""
    rows = {part: [[u.variable.name, [v.name for v in u.knowns], list(u.kinds)] for u in getattr(structure, part)] for part in _PARTS}
    return {**rows, "reinit": sorted(structure.reinit)}


def from_names(names: dict[str, Any]) -> Structure:
    """The structure that was made plain."""
    parts = {
        part: tuple(
            Unknown(kernel.variable(name), tuple(map(kernel.variable, knowns)), tuple(kinds)) for name, knowns, kinds in names[part]
        )
        for part in _PARTS
    }
    return Structure(**parts, reinit=frozenset(names["reinit"]))


def _key(library: Path) -> str:
    here = Path(__file__).resolve().parent
    return key_of(library, sorted(here.glob("*.py")))


@lru_cache(maxsize=1)
def model_structure() -> Structure:
    """The structure of the component, found once for each compiled kernel."""
    library = kernel_library_path()
    place, key = place_of(library), _key(library)
    kept = recall(place, key)
    if kept is not None:
        return from_names(kept)
    structure = find_structure()
    if _key(library) == key:  # else the kernel was compiled anew meanwhile
        keep(place, key, as_names(structure))
    return structure
