"""Which output depends on what? FMI's ModelStructure, found by asking the kernel (probe.py) instead of declaring it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .. import kernel
from ..model import Variable
from .probe import Probe


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


def _running(probe: Probe, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
    """The unknowns with their knowns in the order of the table; a state that is an output follows itself alone."""
    rows = []
    for unknown in unknowns:
        if unknown in probe.states:
            rows.append(Unknown(unknown, (unknown,), ("constant",)))
            continue
        row = probe.unknowns.index(unknown)
        places = _in_order(probe.driven, probe.factors.seen[row])
        kinds = tuple(probe.factors.kind(row, place) if unknown.type == "real" else "dependent" for place in places)
        rows.append(Unknown(unknown, tuple(probe.driven[place] for place in places), kinds))
    return tuple(rows)


def _initial(probe: Probe, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
    """The same for the initialisation, where no kind but the general one is told."""
    rows = []
    for unknown in unknowns:
        places = _in_order(probe.starts, probe.initial[probe.unknowns.index(unknown)])
        rows.append(Unknown(unknown, tuple(probe.starts[place] for place in places), ("dependent",) * len(places)))
    return tuple(rows)


def _in_order(knowns: Sequence[Variable], chosen: npt.NDArray[np.bool_]) -> list[int]:
    return sorted(np.flatnonzero(chosen).tolist(), key=lambda place: knowns[place].index)


@lru_cache(maxsize=1)
def model_structure() -> Structure:
    """The structure of the component."""
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
