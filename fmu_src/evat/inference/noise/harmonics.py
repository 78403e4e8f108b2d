"""What of a recording comes back with its motion? The harmonics of the cycle, of which noise has next to nothing.

What a model lacks in a cut that vibrates is in nearly every sample of a cycle, and jumps at entry and exit: no window between is calm. But
it comes back with the vibration, however fast, and grows or swings over the recording no faster than its slow causes do: wear, heat, a
workpiece that runs out.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import orth

from evat.constants import CONSTANTS
from evat.model import FloatArray


def without_harmonics(row: FloatArray, samples: float) -> FloatArray:
    """A row (n,) of several cycles, of so many samples each, less all that comes back in them with amplitudes that change slowly over it;
    scaled to the size that noise had in it.

    On harmonics it spends no more degrees of freedom than one of the fewest cycles has; on cosines that modulate them one in
    `samples_per_amplitude` of all. A long row is taken in stretches, each long enough for two cosines.
    """
    orders = max(int(samples / 2), int(CONSTANTS.harmonics_of_a_jump))
    longest = 2 * int(CONSTANTS.samples_per_amplitude) * (2 * orders + 1)
    return np.concatenate([_remainder(part, samples, orders) for part in np.array_split(row, max(1, row.size // longest))])


def _remainder(row: FloatArray, samples: float, orders: int) -> FloatArray:
    amplitudes = _amplitudes(row.size, samples, orders)
    remainder: FloatArray = (row - amplitudes @ (amplitudes.T @ row)) * np.sqrt(row.size / (row.size - amplitudes.shape[1]))
    return remainder


@lru_cache(maxsize=8)
def _amplitudes(size: int, samples: float, orders: int) -> FloatArray:
    """An orthonormal basis (size, m) of harmonics whose amplitudes change slowly."""
    most, places = (size / CONSTANTS.fewest_cycles - 1) / 2, np.arange(size)
    angles = 2 * np.pi * np.outer(places, np.arange(1, min(orders, int(most)) + 1)) / samples
    cycle = orth(np.column_stack([np.ones(size), np.cos(angles), np.sin(angles)]))  # some may be harmonics below, seen once more
    count = max(1, int(size / CONSTANTS.samples_per_amplitude / cycle.shape[1]))
    modulations = [np.cos(np.pi * order * (places + 0.5) / size) for order in range(count)]
    amplitudes: FloatArray = orth(np.column_stack([cycle * modulation[:, None] for modulation in modulations]))
    return amplitudes
