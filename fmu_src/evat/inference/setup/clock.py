"""At which times is a run sampled where each channel has a clock of its own?

A force that jumps between two samples is on either side of it in the record, not half way. A prediction at the times of the record that is
then shifted by interpolation is half way, and friction that reverses in a tenth of a sample shows little else: damping has to stand in for
it. So the run itself is sampled where the channels were.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from evat.model import FloatArray


def sample_times(times: FloatArray, late: Sequence[float | FloatArray]) -> tuple[FloatArray, list[npt.NDArray[np.intp]]]:
    """Times (m,) of one run for channels that are so late [s], each alike or so at every sample (n,), beside `times` (n,), none before the
    first; and where each finds its own, (n,)."""
    if not any(np.any(each) for each in late):
        return times, [np.arange(times.size)] * len(late)
    own = [np.maximum(times - each, times[0]) for each in late]
    sampled, places = np.unique(np.concatenate([times[:1], *own]), return_inverse=True)
    return sampled, np.split(places[1:], len(late))
