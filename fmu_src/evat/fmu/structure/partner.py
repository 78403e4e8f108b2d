"""Which output of a partner depends on what? Found by asking it, as for the contact; far simpler, since it has no events and no effects."""

from __future__ import annotations

import random

import numpy as np

from evat.fmu.structure.dependency_kinds import Factors
from evat.fmu.structure.model_structure import Structure, Unknown
from evat.model import FloatArray, Variable
from evat.native.machine import Machine, states, variables

_SEED, _SETTINGS, _POINTS = 20210517, 40, 4  # any fixed number; so many choices of fixed and tunable values, and points of each


def _draw(variable: Variable, luck: random.Random) -> float:
    if variable.type != "real":
        return float(luck.randint(int(variable.min), int(variable.max)))
    size = variable.start if variable.start != 0 and variable.causality == "parameter" else variable.nominal
    value = size * luck.uniform(0.3, 2) * (1 if variable.causality == "parameter" else luck.choice((-1, 1)))
    return min(max(value, variable.min), variable.max)


def _set(one: Machine, variable: Variable, value: float) -> None:
    if variable.causality == "independent":
        one.time = value
    else:
        one.set(variable.name, value)


def _answers(one: Machine, unknowns: tuple[Variable, ...]) -> FloatArray:
    one.evaluate()
    return one.values()[[unknown.index for unknown in unknowns]]


def machine_structure(part: str) -> Structure:
    """FMI's ModelStructure of a partner."""
    every, state_names, luck = variables(part), states(part), random.Random(_SEED)
    own = tuple(next(v for v in every if v.name == name) for name in state_names)
    rates = tuple(next(v for v in every if v.derivative_of == name) for name in state_names)
    outputs = tuple(v for v in every if v.causality == "output")
    unknowns = tuple(sorted({*rates, *(v for v in outputs if v not in own)}, key=lambda v: v.index))
    driven = tuple(v for v in every if v.causality in ("independent", "input")) + own
    fixed, tunable = (tuple(v for v in every if v.causality == "parameter" and v.variability == kind) for kind in ("fixed", "tunable"))
    knowns = (*fixed, *tunable, *driven)
    factors, initial = Factors(len(unknowns), len(driven)), np.zeros((len(unknowns), len(knowns)), dtype=bool)
    all_told = np.ones((len(unknowns), len(driven)), dtype=bool)
    for setting in range(_SETTINGS):
        one = Machine(part)
        if setting % 2 == 0:
            factors.forget("fixed")
            chosen = {v: _draw(v, luck) for v in fixed}
        for variable, value in chosen.items():
            _set(one, variable, value)
        factors.forget("tunable")
        for variable in tunable:
            _set(one, variable, _draw(variable, luck))
        for _ in range(_POINTS):
            for variable in driven:
                _set(one, variable, _draw(variable, luck))
            base, here = _answers(one, unknowns), one.state()
            changes, moves = np.zeros((len(unknowns), len(knowns))), np.ones(len(knowns))
            for place, known in enumerate(knowns):
                value = _draw(known, luck)
                moves[place] = value - (one.time if known.causality == "independent" else one.get(known.name))
                _set(one, known, value)
                changes[:, place] = _answers(one, unknowns) - base
                one.restore(here)
            initial |= changes != 0
            moving = np.where(moves == 0, 1.0, moves)[-len(driven) :]
            factors.add(np.stack([changes[:, -len(driven) :]] * 2), moving, np.abs(base), all_told)

    def running(chosen: tuple[Variable, ...]) -> tuple[Unknown, ...]:
        dependent = []
        for unknown in chosen:
            if unknown in own:
                dependent.append(Unknown(unknown, (unknown,), ("constant",)))
                continue
            row = unknowns.index(unknown)
            places = sorted(np.flatnonzero(factors.seen[row]).tolist(), key=lambda place: driven[place].index)
            dependent.append(Unknown(unknown, tuple(driven[p] for p in places), tuple(factors.kind(row, p) for p in places)))
        return tuple(dependent)

    late = []
    for row, unknown in enumerate(unknowns):
        seen = sorted((knowns[place] for place in np.flatnonzero(initial[row])), key=lambda v: v.index)
        late.append(Unknown(unknown, tuple(seen), ("dependent",) * len(seen)))
    return Structure(running(outputs), running(rates), tuple(late), (), frozenset())
