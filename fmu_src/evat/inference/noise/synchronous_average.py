"""What of a recording comes back with its motion? The time synchronous average (McFadden 1987, not read); noise has little of it.

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


def without_synchronous_average(row: FloatArray, samples: float) -> FloatArray:
    """A row (n,) of several cycles, of so many samples each, less what comes back in them and changes slowly from one to the next; scaled
    to the size that noise had in it.

    The average is a line from phase to phase, as far apart as samples are: a jump that lies elsewhere between two of them in each cycle
    leaves something beside it, and nowhere else. Cosines that modulate it are spent as far as each of their amplitudes has
    `samples_per_amplitude`; a long row is taken in stretches, each long enough for two.
    """
    phases = round(samples)
    longest = 2 * int(CONSTANTS.samples_per_amplitude) * phases
    return np.concatenate([_remainder(part, samples, phases) for part in np.array_split(row, max(1, row.size // longest))])


def _remainder(row: FloatArray, samples: float, phases: int) -> FloatArray:
    averages = _averages(row.size, samples, phases)
    remainder: FloatArray = (row - averages @ (averages.T @ row)) * np.sqrt(row.size / (row.size - averages.shape[1]))
    return remainder


@lru_cache(maxsize=8)
def _averages(size: int, samples: float, phases: int) -> FloatArray:
    """An orthonormal basis (size, m) of what comes back, modulated by cosines."""
    places = np.arange(size)
    before, share = np.divmod(places % samples * (phases / samples), 1.0)
    at = before.astype(np.intp)
    cycle = np.zeros((size, phases))
    np.add.at(cycle, (places, at % phases), 1 - share)
    np.add.at(cycle, (places, (at + 1) % phases), share)
    count = max(1, int(size / CONSTANTS.samples_per_amplitude / phases))
    modulations = [np.cos(np.pi * order * (places + 0.5) / size) for order in range(count)]
    averages: FloatArray = orth(np.column_stack([cycle * modulation[:, None] for modulation in modulations]))
    return averages
