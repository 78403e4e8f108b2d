"""How are residuals weighed that go together? Sample by sample, by the noise: autoregressive within a trial, random effects between trials.

An identification goes by this; a diagnosis, which takes a discrepancy of the model for noise, too, goes by bands of frequency
(band_whitening).

Generalised least squares (Aitken 1936) with the random effects of a linear mixed model (Laird and Ware 1982): with the covariance
S = size^2 (A' A)^-1 + B D B' of a trial, A the autoregressive filter, B what gain, zero, clock and start change in it, D their variances,
S^-1/2 is the filter, followed by shrinking what lies in the span of B.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.linalg import cholesky, solve_triangular, toeplitz

from evat.constants import CONSTANTS
from evat.inference.noise.autoregression import WHITE, autocovariance, innovations
from evat.inference.noise.estimate import Noise, between_trials
from evat.inference.prediction import Prediction
from evat.model import FloatArray


class SampleWhitening:
    """Turns residuals and slopes of an experiment into ones whose noise is independent and of variance 1, sample by sample."""

    def __init__(self, prediction: Prediction, noise: Noise, predicted: FloatArray) -> None:
        """predicted : (N,), near the truth: how gain, zero and clock of a trial show."""
        self.prediction, self.noise, self.predicted = prediction, noise, predicted
        self._between = [self._random_effects(place, predicted) for place in range(len(prediction.segments))]

    def __call__(self, columns: FloatArray) -> FloatArray:
        """A residual (N,) or slopes (N, p), whitened. The first samples of a recording, whose past is unknown, become 0."""
        white = np.array(columns, dtype=np.float64)
        for place, segment in enumerate(self.prediction.segments):
            inner = self._within(place, white[segment.at])
            if (between := self._between[place]) is not None:
                axes, lost = between
                inner = inner - axes @ (lost[:, None] * (axes.T @ inner) if inner.ndim == 2 else lost * (axes.T @ inner))
            white[segment.at] = 0.0
            white[segment.at.stop - len(inner) : segment.at.stop] = inner
        return white

    def within(self) -> SampleWhitening:
        """The same without random effects that are known from repeats alone; how bristles were bent at the start is not."""
        none = {channel: np.zeros_like(spread) for channel, spread in self.noise.spread.items()}
        return SampleWhitening(self.prediction, replace(self.noise, spread=none), self.predicted)

    @property
    def mixed(self) -> bool:
        """Whether there are random effects between trials that repeats tell of."""
        return any(np.any(spread) for spread in self.noise.spread.values())

    def _within(self, place: int, columns: FloatArray) -> FloatArray:
        """Columns of a segment without the noise's correlation: through the filter, or by the whole covariance where the recording is so
        short that its first samples matter."""
        segment = self.prediction.segments[place]
        filter_ = self.noise.filters[segment.channel] if segment.trial >= 0 else WHITE
        if filter_.size == 1 or len(columns) >= CONSTANTS.samples_per_lag * filter_.size:
            inner = innovations(filter_, columns)
        else:
            lower = cholesky(toeplitz(autocovariance(filter_, len(columns))), lower=True)
            inner = solve_triangular(lower, columns, lower=True, check_finite=False)
        white: FloatArray = inner / self.noise.sizes[place]
        return white

    def _random_effects(self, place: int, predicted: FloatArray) -> tuple[FloatArray, FloatArray] | None:
        """Orthonormal axes (n, k) of what differs between trials, and the share (k,) by which whitening shrinks each."""
        segment = self.prediction.segments[place]
        bent = self.prediction.bent[segment.at]
        if segment.trial < 0 or not (np.any(self.noise.spread[segment.channel]) or np.any(bent)):
            return None
        columns = np.column_stack([between_trials(self.prediction, self.noise, segment, predicted), bent])
        axes, sizes, _ = np.linalg.svd(self._within(place, columns), full_matrices=False)
        return axes, 1 - 1 / np.sqrt(1 + sizes**2)
