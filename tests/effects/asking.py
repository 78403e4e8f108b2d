"""How do the tests of the effects ask? With a force that is known, and by its line in a spectrum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np
from driving import AMPLITUDE, OMEGA, Values
from evat.native.kernel import Contact

FASTEST = OMEGA * AMPLITUDE  # m/s
OUTSIDE: Values = {"kinematics": "external", "relative_tolerance": 1e-8}
# One newton for each m/s: Coulomb friction at the smallest that is allowed, 1e-6 N, and viscous friction beside it.
VISCOUS: Values = {"friction_law": "lugre", "F_C": 1e-6, "F_S": 1e-6, "sigma1": 0.0, "sigma2": 1.0}
# A friction force that knows nothing of speed.
CONSTANT: Values = {"friction_law": "coulomb", "F_C": 9.0}


def begun(values: Values, on: Sequence[str] = (), time: float = 0.0) -> Contact:
    contact = Contact({"relative_tolerance": 1e-8, **values}, on)
    contact.start(time)
    return contact


def course(contact: Contact, times: np.ndarray, *names: str) -> np.ndarray:
    """The variables at each of the times, shape (names, times), inputs held."""
    return contact.run(times, {}, names).T


def follow(times: np.ndarray, inputs: Mapping[str, np.ndarray], values: Values, on: Sequence[str], *names: str) -> np.ndarray:
    """The variables along inputs from outside, linear between the samples; shape (names, times)."""
    first = {name: float(column[0]) for name, column in inputs.items()}
    return begun({**OUTSIDE, **values, **first}, on, float(times[0])).run(times, inputs, names).T


def line(frequency: float, times: np.ndarray, signal: np.ndarray) -> np.ndarray:
    """Complex amplitude c of c e^(i 2 pi f t) in evenly sampled whole periods of the signal."""
    return np.asarray(2 * np.mean(signal * np.exp(-2j * pi * frequency * times), axis=-1))
