"""What happens to the component when one known is changed? Settings at random, every known in turn, all unknowns compared."""

from __future__ import annotations

import random

import numpy as np

from .. import kernel
from ..kernel import Contact
from ..model import FloatArray, SimulationError, Variable
from .shown import FmuError

_SEED = 20210517  # any fixed number: same kernel, same structure
_QUIET = 300  # so many settings in a row must bring nothing new before the search ends ...
_LEAST = 1000  # ... and so many must have been looked at
_MOST = 20000
_KINDS = ("constant", "fixed", "tunable")  # with which factor a known enters linearly; else "dependent"


def draw(variable: Variable, luck: random.Random, stay: float = 0.2) -> float:
    """A random value that a user could well set: the start with probability `stay`, else of the order of start or nominal, often far
    below it, and within the bounds."""
    if variable.type != "real":
        return float(luck.randint(int(variable.min), int(variable.max)))
    if luck.random() < stay:
        return variable.start
    if variable.start != 0:
        decades = 0.3 if variable.unit == "K" else 1.5
        value = variable.start * 10 ** luck.uniform(-decades, decades)
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
        """changes[k]: of every unknown, before and after an event, where known k was moved by moves[k]; size: of the unknowns."""
        self.seen |= np.any(changes != 0, axis=1).T
        factors = changes / moves[:, None, None]
        factor = factors[:, 0].T
        blur = 1e-9 * np.abs(factor) + 1e-14 * size[:, None] / np.abs(moves)
        same = np.abs(factors[:, 1].T - factor) <= blur
        for place in range(len(_KINDS)):
            before = self.factor[place]
            first = np.isnan(before)
            self.same[place] &= same & (first | (np.abs(before - factor) <= blur))
            before[first] = factor[first]

    def kind(self, unknown: int, known: int) -> str:
        return next((kind for place, kind in enumerate(_KINDS) if self.same[place, unknown, known]), "dependent")


class Probe:
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
        self.starts = (*self.fixed, *self.tunable, *self.driven)
        self.factors = _Factors(len(self.unknowns), len(self.driven))
        self.initial = np.zeros((len(self.unknowns), len(self.starts)), dtype=bool)
        self.of_the_start = np.array([unknown not in self.indicators for unknown in self.unknowns])  # FMI asks no more
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
        """One choice of all fixed parameters, two of the tunable ones, two operating points each."""
        contact = Contact()
        for variable in self.fixed:
            contact.set(variable.name, draw(variable, self.luck, 0.5))
        if _dear(contact):
            contact.set("initial_state", 0)
        self.factors.forget("fixed")
        try:
            self.tune(contact)
            self.initialise(contact)
            for _ in range(2):
                self.run(contact)
            self.tune(contact)
            for _ in range(2):
                self.run(contact)
        except SimulationError:
            return  # no such operating point: the structure is that of points that exist

    def tune(self, contact: Contact) -> None:
        """One choice of all tunable parameters, inputs and states; near the start values where the start is to find the periodic state,
        which takes long for odd ones."""
        stay = 0.7 if contact.get("initial_state") else 0.2
        for variable in (*self.tunable, *self.driven[1:]):
            contact.set(variable.name, draw(variable, self.luck, stay))
        self.factors.forget("tunable")

    def initialise(self, contact: Contact) -> None:
        """Change one known before the start; only one in eight of them where the start is to find the periodic state."""
        fresh, time = contact.state(), 0.0
        for _ in range(4):  # mostly one that starts in contact
            contact.restore(fresh)
            time = self.luck.uniform(0, 1e-3)
            contact.start(time)
            if contact.get("in_contact"):
                break
        base, started = contact.values()[self.places], contact.state()
        every = range(len(self.starts))
        for place in self.luck.sample(every, len(every) // 8) if contact.get("initial_state") else every:
            known = self.starts[place]
            contact.restore(fresh)
            contact.time = time
            _put(contact, known, _other(contact, known, self.luck))
            if not _dear(contact):
                contact.start(contact.time)
                self.initial[:, place] |= self.of_the_start & (contact.values()[self.places] != base)
        contact.restore(started)

    def move(self, contact: Contact) -> None:
        """Go to another operating point: later, other inputs and states, the sides of the events taken anew; mostly one in contact."""
        for _ in range(5):
            for variable in self.driven:
                _put(contact, variable, _other(contact, variable, self.luck))
            contact.event()
            if contact.get("in_contact") or self.luck.random() < 0.1:
                return

    def run(self, contact: Contact) -> None:
        """Change one known at a new operating point, in continuous time and at an event."""
        self.move(contact)
        here = contact.state()
        base = np.empty((2, len(self.unknowns)))
        self.respond(contact, base)
        values = np.empty((len(self.driven), *base.shape))
        moves = np.empty(len(self.driven))
        for place, known in enumerate(self.driven):
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
