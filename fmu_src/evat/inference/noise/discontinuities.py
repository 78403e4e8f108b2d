"""What may be wrong beside a jump of a prediction, and wherever else a sample is unsure? No model has the place of a jump right to a
fraction of a sample.

So each sample that stands where the prediction bends is unsure by a share of that bend, on its own. Filtered with the noise, such an error
reaches as many innovations as the filter has lags: the covariance stays that of the noise but for small blocks.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.ndimage import median_filter

from evat.constants import CONSTANTS
from evat.model import FloatArray


class Discontinuities:
    """The whitening of one segment: `weights` (L,) are what its samples count, `share` what all of them do."""

    def __init__(self, predicted: FloatArray, filter_: FloatArray, size: float, unsure: FloatArray | float = 0.0) -> None:
        """predicted : (L,); filter_ : (1, a_1, ...), turns noise into innovations of the sd `size`; unsure : (L,), sd of what else may be
        wrong in each sample on its own."""
        error = np.minimum(np.hypot(CONSTANTS.bend_error * bends(predicted), unsure) / size, CONSTANTS.largest_bend_error)
        error[error < CONSTANTS.least_bend_error] = 0.0
        self.weights: FloatArray = 1 / np.sqrt(1 + error**2)
        self._blocks = _blocks(error, filter_)
        length = predicted.size - filter_.size + 1
        lost = sum(float(at.size - np.sum(block**2)) for at, block in self._blocks)
        self.share = 1 - lost / max(length, 1)

    def whiten(self, innovations: FloatArray) -> FloatArray:
        """Innovations (L - lags, p) of unit variance where the errors beside jumps are counted in."""
        if not self._blocks:
            return innovations
        white = innovations.copy()
        for at, block in self._blocks:
            white[at] = block @ innovations[at]
        return white


def bends(predicted: FloatArray) -> FloatArray:
    """Second differences that stand out from those around them: a curve is no jump."""
    return np.abs(_bends(predicted))


def rises(predicted: FloatArray) -> FloatArray:
    """Of samples in the middle of a rise, which bends one way before them and the other behind, the smaller of these bends; else 0."""
    bend, middle = _bends(predicted), np.zeros(predicted.size)
    if predicted.size > 2:
        size = np.minimum(np.abs(bend[:-2]), np.abs(bend[2:]))
        middle[1:-1] = np.where(bend[:-2] * bend[2:] < 0, size, 0.0)
    return middle


def _bends(predicted: FloatArray) -> FloatArray:
    excess = np.zeros(predicted.size)
    if predicted.size > 2:
        second = np.diff(predicted, 2)
        excess[1:-1] = second - median_filter(second, CONSTANTS.curve_samples)
    return excess


def _blocks(error: FloatArray, filter_: FloatArray) -> list[tuple[npt.NDArray[np.intp], FloatArray]]:
    """Places (n, w) of innovations that errors reach together, and (I + errors)^(-1/2) of them (n, w, w)."""
    lost, unsure = filter_.size - 1, np.flatnonzero(error)
    reached = np.unique(np.clip(unsure[:, None] - lost + np.arange(filter_.size), 0, error.size - lost - 1))
    runs = np.split(reached, np.flatnonzero(np.diff(reached) > 1) + 1) if reached.size else []
    by_width: dict[int, list[npt.NDArray[np.intp]]] = {}
    for run in runs:
        for part in np.array_split(run, -(-run.size // CONSTANTS.widest_block)):
            by_width.setdefault(part.size, []).append(part)
    blocks = []
    for parts in by_width.values():
        at = np.array(parts)
        samples = at[:, :1] + np.arange(at.shape[1] + lost)  # what the innovations of a block see
        lags = np.arange(at.shape[1])[:, None] + lost - np.arange(samples.shape[1])
        response = np.where((lags >= 0) & (lags <= lost), filter_[np.clip(lags, 0, lost)], 0.0)
        columns = response * error[samples][:, None, :]
        values, vectors = np.linalg.eigh(np.eye(at.shape[1]) + columns @ columns.transpose(0, 2, 1))
        blocks.append((at, (vectors / np.sqrt(np.maximum(values, 1.0))[:, None, :]) @ vectors.transpose(0, 2, 1)))
    return blocks
