"""Why may recalibration leave more newtons than the nominal values did? Because it weighs what it leaves by how sure that is.

Nominal values that were themselves fitted by plain least squares have the smallest root mean square that there is, by definition. A fit
that knows the noise prefers others: what noise of long memory, a gain or a zero that differ from trial to trial may as well be counts
next to nothing, and shape counts the more. Both figures are told where they disagree.
"""

from __future__ import annotations

import math

from evat.constants import CONSTANTS
from evat.gap.budget import squares
from evat.gap.search.compare import Comparison
from evat.inference.band_whitening import BandWhitening
from evat.inference.discrepancy import known
from evat.inference.fit import Fit


def raised(comparison: Comparison) -> tuple[str, ...]:
    """A sentence for each channel in which recalibration leaves more than the nominal values did, and is likelier all the same."""
    whitening, nominal, refit = comparison.whitening, comparison.nominal, comparison.recalibrated
    gain = refit.likelihood.evidence - nominal.likelihood.evidence
    if gain <= 0:
        return ()
    before, after = squares(whitening, nominal.predicted), squares(whitening, refit.predicted)
    weighed = tuple(_weighed(whitening, fit) for fit in (nominal, refit))
    sentences = []
    for channel in before:
        left, leaves = math.sqrt(before[channel].left), math.sqrt(after[channel].left)
        if leaves > CONSTANTS.noticeable_rise * left:
            sentences.append(
                f"{channel}: recalibration raises the plain rms from {left:.4g} to {leaves:.4g}, and changes the one weighed by the noise "
                f"from {weighed[0]:.3g} to {weighed[1]:.3g} standard deviations (log evidence +{gain:.0f}){_why(comparison, channel)}. "
                "Values by plain least squares have the smallest plain rms by definition"
            )
    return tuple(sentences)


def _why(comparison: Comparison, channel: str) -> str:
    """What makes levels count little and shapes much."""
    reasons = []
    if channel in comparison.noise.spread:
        reasons.append(f"gains differ by {comparison.noise.spread[channel][0]:.1%} from trial to trial")
    if channel in comparison.noise.filters and comparison.noise.filters[channel].size > 1:
        reasons.append("the noise goes on from sample to sample")
    return f": {' and '.join(reasons)}, so levels count less than shapes" if reasons else ""


def _weighed(whitening: BandWhitening, fit: Fit) -> float:
    """Root mean square of what is left, by the covariance of the noise and of what differs between trials: 1 is noise alone."""
    trust = whitening.trust[..., None, None]
    return math.sqrt(float(known(fit.sums.grams * trust, 1 / whitening.least)[-1, -1]) / float((whitening.counts * whitening.trust).sum()))
