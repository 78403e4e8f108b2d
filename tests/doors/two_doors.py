"""How is one contact run through the kernel and through an FMU alike? Values in the kernel's words, all variables back, as bits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from evat.model import FIRST_ITEM
from evat.native import kernel
from raw_fmi import BOOLEAN, INTEGER, OK, REAL, Instance

Values = Mapping[str, float | str]

# What the doors must agree on, and its place in the kernel's own list. FMI calls choices by items that start at FIRST_ITEM.
SHOWN = [v for v in kernel.variables() if v.type != "choice"]
PLACES = np.array([v.index for v in SHOWN])


def in_fmi(values: Values, effects: Sequence[str] = ()) -> dict[str, float]:
    """Values as the FMU takes them."""
    numbers = kernel.check_values(values, effects)
    return {name: number + (FIRST_ITEM if kernel.variable(name).type == "choice" else 0) for name, number in numbers.items()}


def of_kernel(contact: kernel.Contact) -> np.ndarray:
    """All variables but the choices."""
    return np.asarray(contact.values()[PLACES])


def of_fmu(instance: Instance) -> np.ndarray:
    """The same through the FMU's getters, one call for each type."""
    values_by_place = np.empty(len(SHOWN))
    for kind in (REAL, INTEGER, BOOLEAN):
        places = [place for place, v in enumerate(SHOWN) if v.type == kind]
        status, values = instance.get_as(kind, [instance.door.reference[SHOWN[place].name] for place in places])
        assert status == OK, instance.lines
        values_by_place[places] = values
    return values_by_place


def differing(one: np.ndarray, other: np.ndarray) -> list[str]:
    """Names of the variables that are not the same number to the last bit in some row; a NaN is never the same."""
    return [SHOWN[place].name for place in np.flatnonzero(np.any(np.atleast_2d(one) != np.atleast_2d(other), axis=0))]
