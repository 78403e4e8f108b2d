"""What happens to the component when a known is changed? Settings at random, every known changed, all unknowns compared.

Knowns that have shown the same so far are changed together, and one after the other only where that shows something new. A parameter of a
law or an effect is not changed before a start, what follows the switch is taken to follow it; nor is the periodic state looked for, what
follows a state is taken to follow what the search for it follows. So the cost grows with the number of inputs, states and switches only.
What takes several rare choices at once is found from neighbours: half of the settings are like one that has shown something new.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from evat.fmu.structure.dependency_kinds import Factors, Mask
from evat.fmu.structure.random_values import draw, other, put, read
from evat.model import BuildError, Effect, FloatArray, SimulationError, Variable
from evat.native import kernel
from evat.native.kernel import Contact

_SEED = 20210517  # any fixed number: same kernel, same structure
_QUIET = {"run": 1000, "start": 300}  # so many settings in a row must bring nothing new before a search ends
_MOST = 20000
_FEW = 3  # effects on, so that none hides the others; in other settings half of them are, so that they meet
_LATEST = 20  # settings that have shown something new, near which others are looked at
_NEAR = 0.5  # share of the settings that are near one of them
_CHANGED = 0.1  # share of the fixed parameters in which such a neighbour is drawn anew

Answer = Callable[[Contact], FloatArray]
Setting = dict[str, float]  # a choice of all fixed parameters, by name


@dataclass(frozen=True, slots=True)
class Change:
    """Knowns that were changed together, by how much each, and what that did to the unknowns, shape (1 or 2, unknowns)."""

    places: list[int]
    moves: list[float]
    unknowns: FloatArray


def choose_effects(luck: random.Random, share: float) -> set[str]:
    """Effects that are on, each with probability `share`, at most one of those that are rivals."""
    effects = list(kernel.effects())
    luck.shuffle(effects)
    on: set[str] = set()
    for effect in effects:
        if luck.random() < share and not on & _rivals(effect):
            on.add(effect.name)
    return on


def _rivals(effect: Effect) -> set[str]:
    return {*effect.rivals, *(each.name for each in kernel.effects() if effect.name in each.rivals)} - {effect.name}


class Probe:
    """Collects which unknowns follow which knowns."""

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
        self.laws = {own.name: law.name for law in kernel.laws() for own in law.variables}
        self.owner = self.laws | {own.name: effect.name for effect in kernel.effects() for own in (*effect.variables, *effect.states)}
        own = (v for v in (*self.fixed, *self.tunable) if v.name not in self.owner and v.name not in ("initial_state", "averaging"))
        self.starts = (*own, *self.driven)
        self.factors = Factors(len(self.unknowns), len(self.driven))
        self.factors.same[:, [v.type != "real" for v in self.unknowns]] = False  # only real numbers have factors
        self.initial = np.zeros((len(self.unknowns), len(self.starts)), dtype=bool)
        self.initial[[v in self.indicators for v in self.unknowns]] = True  # FMI does not ask; so nothing there is news
        steps = ("initial_state", "averaging", "relative_tolerance", "averaging_window")
        self.of_cycles = {*steps, *(effect.name for effect in kernel.effects())}
        # What follows one of these follows all that a cycle follows; the window: a mean does, which a cycle gives at the start.
        self.moving = np.array([v.causality == "independent" or v in self.states or v.name == "averaging_window" for v in self.starts])
        self.reinit = np.zeros(len(self.states), dtype=bool)
        self.luck = random.Random(_SEED)
        self.state_places = np.array([v.index for v in self.states])
        self.places = np.array([v.index for v in self.unknowns])
        self.fruitful: list[Setting] = []
        self.idle: set[str] = set()  # variables of laws and effects that the present setting does without
        self.period = 0.0  # of its vibration [s]

    def search(self) -> None:
        """Look at settings until nothing new turns up, at operating points and at starts."""
        quiet = dict.fromkeys(_QUIET, 0)
        for _ in range(_MOST):
            wanted = {part for part in _QUIET if quiet[part] < _QUIET[part]}
            if not wanted:
                return
            before = self._counts()
            setting = self.choose()
            self.look(setting, wanted)
            now = self._counts()
            if now != before:
                self.fruitful = [*self.fruitful, setting][-_LATEST:]
            quiet |= {part: quiet[part] + 1 if now[part] == before[part] else 0 for part in wanted}
        raise BuildError(f"the model structure did not settle within {_MOST} random settings; raise _MOST.")

    def _counts(self) -> dict[str, int]:
        """Pairs of unknown and known that a look has told of, in a run and at a start."""
        run = self.reinit.sum() + self.factors.seen.sum() - self.factors.same.sum()
        return {"run": int(run), "start": int(self.told_at_rest.sum())}

    @property
    def told_at_rest(self) -> Mask:
        """Pairs of which a further start can tell nothing: what was seen, and what follows from that by the rule of initial_knowns."""
        of_rates = self.initial[[v in self.rates for v in self.unknowns]].any(axis=0)
        of_cycles = of_rates | np.array([v.name in self.of_cycles for v in self.starts])
        moves = self.initial[:, self.moving].any(axis=1)
        told: Mask = self.initial | np.outer(moves, of_cycles)
        return told

    def initial_knowns(self, unknown: Variable) -> list[Variable]:
        """What the unknown follows after a start: seen at rest; and where it follows a state, the time or a window of means also all that
        a cycle follows, which the search for the periodic states and the averaging run, in internal steps that every effect may
        shorten."""
        needed = self._seen_at_rest(unknown)
        if needed & {known.name for known, moves in zip(self.starts, self.moving, strict=True) if moves}:
            needed |= {name for rate in self.rates for name in self._seen_at_rest(rate)} | self.of_cycles
        switch = {name: "friction_law" if name in self.laws else owner for name, owner in self.owner.items()}
        needed |= {v.name for v in (*self.fixed, *self.tunable) if switch.get(v.name) in needed}
        return [v for v in (*self.fixed, *self.tunable, *self.driven) if v.name in needed]

    def _seen_at_rest(self, unknown: Variable) -> set[str]:
        row = self.initial[self.unknowns.index(unknown)]
        return {known.name for known, follows in zip(self.starts, row, strict=True) if follows}

    def choose(self) -> Setting:
        """Fixed parameters at random, or in half of the cases near those of a setting that has lately shown something new."""
        effects = {effect.name: effect for effect in kernel.effects()}
        near = self.luck.choice(self.fruitful) if self.fruitful and self.luck.random() < _NEAR else None
        if near is None:
            on = choose_effects(self.luck, min(0.5, _FEW / max(len(effects), 1)) if self.luck.random() < 0.5 else 0.5)
        else:
            on = {name for name in effects if near[name]}
            for name in self.luck.choices(list(effects), k=2):
                if name in on:
                    on.remove(name)
                elif not on & _rivals(effects[name]):
                    on.add(name)
        setting = {name: float(name in on) for name in effects}
        for variable in self.fixed:
            if variable.name not in setting:
                if near is None or self.luck.random() < _CHANGED:
                    setting[variable.name] = draw(variable, self.luck, 0.5)
                else:
                    setting[variable.name] = near[variable.name]
        return setting

    def look(self, setting: Setting, wanted: set[str]) -> None:
        """At one setting: three starts; two choices of the tunable parameters, two operating points each."""
        contact = Contact()
        for name, value in setting.items():
            if name != "averaging":  # a mean over a cycle follows all that the cycle does
                contact.set(name, value)
        on = {effect.name for effect in kernel.effects() if setting[effect.name]}
        contact.set("initial_state", "at_rest")  # to look for the periodic states takes long
        active = {*on, kernel.variable("friction_law").choices[int(contact.get("friction_law"))]}
        self.idle = {name for name, owner in self.owner.items() if owner not in active}
        self.period = 1 / contact.get("vibration_frequency")
        self.factors.forget("fixed")
        try:
            chosen = contact.state()
            for _ in range(3 if "start" in wanted else 1):
                contact.restore(chosen)
                self.tune(contact)
                self.initialise(contact, "start" in wanted)
            for again in range(4 if "run" in wanted else 0):
                if again == 2:
                    self.tune(contact)
                self.run(contact)
        except SimulationError:
            return  # no such operating point: the structure is that of points that exist

    def tune(self, contact: Contact) -> None:
        """One choice of all tunable parameters, inputs and states."""
        for variable in (*self.tunable, *self.driven[1:]):
            if variable.name not in self.idle:
                contact.set(variable.name, draw(variable, self.luck))
        self.factors.forget("tunable")

    def groups(self, knowns: Sequence[Variable], settled: Mask, alone: Mask) -> list[list[int]]:
        """Places of knowns that have shown the same so far; those of what the setting does without together, if at all; `alone`
        by themselves."""
        by_answer: dict[object, list[int]] = {}
        look_at_idle = self.luck.random() < 0.1  # nothing is expected of them
        of_known = np.ascontiguousarray(settled.T)
        for place, known in enumerate(knowns):
            idle = known.name in self.idle
            if look_at_idle or not idle:
                key = "idle" if idle else place if alone[place] else of_known[place].tobytes()
                by_answer.setdefault(key, []).append(place)
        return list(by_answer.values())

    def changes(
        self, contact: Contact, knowns: Sequence[Variable], group: list[int], base: FloatArray, answer: Answer, settled: Mask
    ) -> list[Change]:
        """Change the knowns of a group together; where an unknown follows that need not follow all of them, one after the other."""
        here = contact.state()
        old = [read(contact, knowns[place]) for place in group]
        new = [other(knowns[place], now, self.luck, self.period) for place, now in zip(group, old, strict=True)]
        moves = [after - before for before, after in zip(old, new, strict=True)]
        for place, value in zip(group, new, strict=True):
            put(contact, knowns[place], value)
        together = _attempt(contact, answer)
        contact.restore(here)
        if together is not None:
            change = together - base
            if len(group) == 1 or not np.any(np.any(change != 0, axis=0) & ~settled[:, group].all(axis=1)):
                return [Change(group, moves, change)]
        differences = []
        for place, value, move in zip(group, new, moves, strict=True) if len(group) > 1 else ():
            before = contact.state()
            put(contact, knowns[place], value)
            changed = contact.state()
            values = _attempt(contact, answer)
            contact.restore(before if values is None else changed)
            if values is not None:
                differences.append(Change([place], [move], values - base))
                base = values
        contact.restore(here)
        return differences

    def initialise(self, contact: Contact, look: bool) -> None:
        """Start, mostly in contact, and change knowns before the start."""
        fresh = contact.state()
        for _ in range(4):
            contact.restore(fresh)
            contact.time = self.luck.uniform(0, 1e-3)
            ready = contact.state()
            base = self.start(contact)
            if contact.get("in_contact"):
                break
        started = contact.state()
        contact.restore(ready)
        alone, told = np.zeros(len(self.starts), dtype=bool), self.told_at_rest
        for group in self.groups(self.starts, told, alone) if look else ():
            for change in self.changes(contact, self.starts, group, base, self.start, told):
                if len(change.places) == 1:
                    self.initial[:, change.places[0]] |= change.unknowns[0] != 0
        contact.restore(started)

    def start(self, contact: Contact) -> FloatArray:
        """The unknowns after a start at the contact's time, shape (1, unknowns)."""
        contact.start(contact.time)
        return contact.values()[None, self.places]

    def move(self, contact: Contact) -> None:
        """Go to another operating point: later, other inputs and states, the sides of the events taken anew; mostly one in contact."""
        for _ in range(5):
            for variable in self.driven:
                put(contact, variable, other(variable, read(contact, variable), self.luck, self.period))
            contact.event()
            if contact.get("in_contact") or self.luck.random() < 0.1:
                return

    def run(self, contact: Contact) -> None:
        """Change knowns at a new operating point, in continuous time and at an event."""
        self.move(contact)
        here = contact.state()
        base = self.respond(contact)
        contact.restore(here)
        settled = self.factors.settled
        shape = (len(self.unknowns), len(self.driven))
        changes, moves, told = np.zeros((2, *shape)), np.ones(len(self.driven)), np.zeros(shape, dtype=bool)
        for group in self.groups(self.driven, settled, np.any(self.factors.seen & ~settled, axis=0)):
            for change in self.changes(contact, self.driven, group, base, self.respond, settled):
                moves[change.places] = change.moves
                if len(change.places) == 1:
                    changes[:, :, change.places[0]] = change.unknowns
                    told[:, change.places[0]] = True
                else:  # what has not followed all of them has not followed any
                    told[:, change.places] = ~np.any(change.unknowns, axis=0)[:, None]
        self.factors.add(changes, moves, np.max(np.abs(base), axis=0), told)

    def respond(self, contact: Contact) -> FloatArray:
        """The unknowns, shape (2, unknowns): in continuous time, and after an event."""
        contact.evaluate()
        before = contact.values()
        contact.event()
        after = contact.values()
        self.reinit |= (after != before)[self.state_places]
        return np.array((before[self.places], after[self.places]))


def _attempt(contact: Contact, answer: Answer) -> FloatArray | None:
    """The answer, or None where there is no such operating point."""
    try:
        return answer(contact)
    except SimulationError:
        return None
