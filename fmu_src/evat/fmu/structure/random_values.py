"""Which values could a user well set? Random ones within the bounds, of the order of start or nominal."""

from __future__ import annotations

import random

from evat.model import BuildError, Variable
from evat.native.kernel import Contact


def draw(variable: Variable, luck: random.Random, stay: float = 0.2) -> float:
    """A random value: the start with probability `stay`, else of the order of start or nominal, often far below it, seldom far above."""
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
        size = luck.uniform(0, 2) if luck.random() < 0.5 else 10 ** luck.uniform(-5, 2.5)
        value = variable.nominal * size * luck.choice((-1, 1))
    return min(max(abs(value) if variable.min >= 0 else value, variable.min), variable.max)


def read(contact: Contact, variable: Variable) -> float:
    """The present value of a known, time among them."""
    return contact.time if variable.causality == "independent" else contact.get(variable.name)


def put(contact: Contact, variable: Variable, value: float) -> None:
    """Set a known, time among them."""
    if variable.causality == "independent":
        contact.time = value
    else:
        contact.set(variable.name, value)


def other(variable: Variable, now: float, luck: random.Random, period: float) -> float:
    """Another value than the present one; for time a later one, by the order of a vibration period."""
    if variable.causality == "independent":
        return now + luck.uniform(0.05, 1.5) * period
    for _ in range(50):
        value = draw(variable, luck)
        if value != now:
            return value
    raise BuildError(f"{variable.name} has only one value, {now:g}; it cannot be a known of the model structure. Correct its bounds.")
