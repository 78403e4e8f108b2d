"""Which output depends on what? Found by asking the kernel: change one known at a time and see which unknowns follow."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from .. import kernel
from ..kernel import Contact
from ..model import FloatArray, SimulationError, Variable
from .shown import FmuError

_SEED = 20210517  # any fixed number: same kernel, same structure
_QUIET = 300  # so many settings in a row must bring nothing new before the search ends ...
_LEAST = 1200  # ... and so many must have been looked at
_MOST = 20000
_KINDS = ("constant", "fixed", "tunable")  # with which factor a known enters linearly; else "dependent"


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


def draw(variable: Variable, luck: random.Random, stay: float = 0.2) -> float:
    """A random value that a user could well set: the start with probability `stay`, else of the order of start or nominal, often far
    below it, and within the bounds."""
    if variable.type != "real":
        return float(luck.randint(int(variable.min), int(variable.max)))
    if luck.random() < stay:
        return variable.start
    if variable.start != 0:
        value = variable.start * 10 ** luck.uniform(-1.5, 1.5)
        if variable.min < 0 < variable.max and luck.random() < 0.3:
            value = -value
    else:
        size = luck.uniform(0, 2) if luck.random() < 0.5 else 10 ** luck.uniform(-5, 1.5)
        value = variable.nominal * size * luck.choice((-1, 1))
    return min(max(abs(value) if variable.min >= 0 else value, variable.min), variable.max)


def _put(contact: Contact, variable: Variable, value: float) -> None:
    if variable.causality == "independent":
        contact.time = value
    else:
        contact.set(variable.name, value)


def _other(contact: Contact, variable: Variable, luck: random.Random) -> float:
    """Another value than the present one; for time a later one."""
    if variable.causality == "independent":
        return contact.time + luck.uniform(0.05, 1.5) / contact.get("vibration_frequency")
    now = contact.get(variable.name)
    for _ in range(50):
        value = draw(variable, luck)
        if value != now:
            return value
    raise FmuError(f"{variable.name} has only one value, {now:g}; it cannot be a known of the model structure. Correct its bounds.")


def _dear(contact: Contact) -> bool:
    """Would a start search the periodic state with the slip solved at every step? It is long, and what it may depend on is seen from
    either of the two alone."""
    return contact.get("initial_state") != 0 and contact.get("chip_flow_angle") != 0


class _Factors:
    """With which factor does each known enter each unknown, and how long does the factor stay the same?"""

    def __init__(self, unknowns: int, knowns: int) -> None:
        self.seen = np.zeros((unknowns, knowns), dtype=bool)
        self.same = np.ones((len(_KINDS), unknowns, knowns), dtype=bool)
        self.factor = np.full((len(_KINDS), unknowns, knowns), np.nan)

    def forget(self, kind: str) -> None:
        """Parameters have changed on which factors of this kind may depend."""
        self.factor[_KINDS.index(kind)] = np.nan

    def add(self, changes: FloatArray, moves: FloatArray, size: FloatArray) -> None:
        """changes[k]: of every unknown, before and after an event, where known k was moved by moves[k]; size: of the unknowns.
        Of the knowns there may be only the first few."""
        self.seen[:, : len(moves)] |= np.any(changes != 0, axis=1).T
        factors = changes / moves[:, None, None]
        factor = factors[:, 0].T
        blur = 1e-9 * np.abs(factor) + 1e-14 * size[:, None] / np.abs(moves)
        same = np.abs(factors[:, 1].T - factor) <= blur
        for place in range(len(_KINDS)):
            before = self.factor[place, :, : len(moves)]
            first = np.isnan(before)
            self.same[place, :, : len(moves)] &= same & (first | (np.abs(before - factor) <= blur))
            before[first] = factor[first]

    def kind(self, unknown: int, known: int) -> str:
        return next((kind for place, kind in enumerate(_KINDS) if self.same[place, unknown, known]), "dependent")


class _Probe:
    """Settings at random, one known changed at a time; collects which unknowns follow."""

    def __init__(self) -> None:
        every = kernel.variables()
        state_names = kernel.states()
        self.states = tuple(kernel.variable(name) for name in state_names)
        self.fixed = tuple(v for v in every if v.causality == "parameter" and v.variability == "fixed")
        self.tunable = tuple(v for v in every if v.causality == "parameter" and v.variability == "tunable")
        self.driven = tuple(v for v in every if v.causality in ("independent", "input")) + self.states
        self.outputs = tuple(v for v in every if v.causality == "output" and v.name not in state_names)
        self.rates = tuple(next(v for v in every if v.derivative_of == name) for name in state_names)
        self.indicators = tuple(kernel.variable(name) for name in kernel.indicators())
        self.unknowns = tuple(sorted({*self.outputs, *self.rates, *self.indicators}, key=lambda v: v.index))
        self.knowns = (*self.driven, *self.tunable)
        self.starts = (*self.fixed, *self.knowns)
        self.factors = _Factors(len(self.unknowns), len(self.knowns))
        self.initial = np.zeros((len(self.unknowns), len(self.starts)), dtype=bool)
        self.reinit = np.zeros(len(self.states), dtype=bool)
        self.luck = random.Random(_SEED)
        self.state_places = np.array([v.index for v in self.states])
        self.places = np.array([v.index for v in self.unknowns])

    def search(self) -> None:
        """Look at settings until nothing new turns up."""
        quiet, before = 0, -1
        for count in range(_MOST):
            if quiet >= _QUIET and count >= _LEAST:
                return
            self.setting()
            found = self.initial.sum() + self.reinit.sum() + self.factors.seen.sum() - self.factors.same.sum()
            quiet, before = (quiet + 1, before) if found == before else (0, found)
        raise FmuError(f"the model structure did not settle within {_MOST} random settings; raise _MOST.")

    def setting(self) -> None:
        """One choice of all fixed parameters, two of the tunable ones, three operating points."""
        contact = Contact()
        for variable in self.fixed:
            contact.set(variable.name, draw(variable, self.luck, 0.5))
        if _dear(contact):
            contact.set("initial_state", 0)
        self.factors.forget("fixed")
        try:
            self.tune(contact)
            self.initialise(contact)
            self.run(contact, self.knowns)
            self.run(contact, self.driven)
            self.tune(contact)
            self.run(contact, self.driven)
        except SimulationError:
            return  # no such operating point: the structure is that of points that exist

    def tune(self, contact: Contact) -> None:
        """One choice of all tunable parameters, inputs and states."""
        for variable in (*self.tunable, *self.driven[1:]):
            contact.set(variable.name, draw(variable, self.luck))
        self.factors.forget("tunable")

    def initialise(self, contact: Contact) -> None:
        """Change one known before the start."""
        fresh, time = contact.state(), self.luck.uniform(0, 1e-3)
        contact.start(time)
        base, started = contact.values()[self.places], contact.state()
        for place, known in enumerate(self.starts):
            contact.restore(fresh)
            contact.time = time
            _put(contact, known, _other(contact, known, self.luck))
            if not _dear(contact):
                contact.start(contact.time)
                self.initial[:, place] |= contact.values()[self.places] != base
        contact.restore(started)

    def move(self, contact: Contact) -> None:
        """Go to another operating point: later, other inputs and states, the sides of the events taken anew; mostly one in contact."""
        for _ in range(5):
            for variable in self.driven:
                _put(contact, variable, _other(contact, variable, self.luck))
            contact.event()
            if contact.get("in_contact") or self.luck.random() < 0.1:
                return

    def run(self, contact: Contact, knowns: Sequence[Variable]) -> None:
        """Change one known at a new operating point, in continuous time and at an event. The first of all knowns come first."""
        self.move(contact)
        here = contact.state()
        base = np.empty((2, len(self.unknowns)))
        self.respond(contact, base)
        values = np.empty((len(knowns), *base.shape))
        moves = np.empty(len(knowns))
        for place, known in enumerate(knowns):
            contact.restore(here)
            old = contact.time if known.causality == "independent" else contact.get(known.name)
            new = _other(contact, known, self.luck)
            _put(contact, known, new)
            self.respond(contact, values[place])
            moves[place] = new - old
        self.factors.add(values - base, moves, np.max(np.abs(base), axis=0))
        contact.restore(here)

    def respond(self, contact: Contact, values: FloatArray) -> None:
        """Fill in the unknowns: values[0] in continuous time, values[1] after an event."""
        contact.evaluate()
        before = contact.values()
        contact.event()
        after = contact.values()
        self.reinit |= (after != before)[self.state_places]
        values[0], values[1] = before[self.places], after[self.places]

    def listed(self, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
        """The unknowns with their knowns in the order of the table; a state that is an output follows itself alone."""
        rows = []
        for unknown in unknowns:
            if unknown in self.states:
                rows.append(Unknown(unknown, (unknown,), ("constant",)))
                continue
            row = self.unknowns.index(unknown)
            places = _in_order(self.knowns, self.factors.seen[row])
            kinds = tuple(self.factors.kind(row, place) if unknown.type == "real" else "dependent" for place in places)
            rows.append(Unknown(unknown, tuple(self.knowns[place] for place in places), kinds))
        return tuple(rows)

    def listed_initially(self, unknowns: Sequence[Variable]) -> tuple[Unknown, ...]:
        """The same for the initialisation, where no kind but the general one is told."""
        rows = []
        for unknown in unknowns:
            places = _in_order(self.starts, self.initial[self.unknowns.index(unknown)])
            rows.append(Unknown(unknown, tuple(self.starts[place] for place in places), ("dependent",) * len(places)))
        return tuple(rows)


def _in_order(knowns: Sequence[Variable], chosen: npt.NDArray[np.bool_]) -> list[int]:
    return sorted(np.flatnonzero(chosen).tolist(), key=lambda place: knowns[place].index)


@lru_cache(maxsize=1)
def model_structure() -> Structure:
    """The structure of the component."""
    probe = _Probe()
    probe.search()
    late = sorted({*probe.outputs, *probe.rates}, key=lambda v: v.index)
    return Structure(
        outputs=probe.listed([v for v in kernel.variables() if v.causality == "output"]),
        derivatives=probe.listed(probe.rates),
        initial_unknowns=probe.listed_initially(late),
        indicators=probe.listed(probe.indicators),
        reinit=frozenset(state.name for state, is_set in zip(probe.states, probe.reinit, strict=True) if is_set),
    )
