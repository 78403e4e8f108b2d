"""What should be recorded so that a contact's parameters show? Motions, speeds, rates and repeats, scaled by what is believed of it.

Bristles bend over z = max(F_C, F_S)/sigma0 before they slide; the Stribeck curve falls over v_s. Strokes and speeds are multiples of these,
the shares are those of evat.motions.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from evat.model import ParameterError
from evat.motions import AMPLITUDES, STROKE, STROKES
from evat.native import kernel

REPEATS = 3  # of a condition: the noise is told by what they do not share, and two cannot tell which of them is off
PER_BEND = 20  # samples while bristles bend: their stiffness and damping are read off these
SPEEDS = (0.1, 0.3, 1.0, 3.0, 10.0)  # of v_s: two on the falling branch, two where it has fallen
SECONDS = 2.0  # at a steady speed: gain and zero of a repeat are means over it
LONGEST = 100  # lengths z that a recording at a steady speed slides at least


@dataclass(frozen=True, slots=True)
class Advised:
    """A motion, what it shows, and how to record it: SI; `speeds` [m/s] or `strokes` [m], one condition each."""

    motion: str
    shows: tuple[str, ...]
    speeds: tuple[float, ...]
    strokes: tuple[float, ...]
    seconds: float
    rate: float
    why: str
    repeats: int = REPEATS


def recordings(values: Mapping[str, float | str]) -> tuple[Advised, ...]:
    """What to record of a contact with these values; what they lack is as the component starts."""
    force = max(_value(values, "F_C"), _value(values, "F_S"))
    length, stribeck = force / _value(values, "sigma0"), _value(values, "v_s")
    if not (math.isfinite(length) and length > 0):
        raise ParameterError(f"F_C, F_S = {force:g} N over sigma0: a length above 0 is needed.")
    speeds = tuple(share * stribeck for share in SPEEDS)
    # At the speed at which a reversal crosses the bend: PER_BEND samples over a length z.
    crossing = PER_BEND * stribeck / length
    period = max(SECONDS, LONGEST * length / speeds[0])
    stroke_rate = PER_BEND * speeds[0] / length
    strokes = tuple(share * length for share in AMPLITUDES)
    return (
        Advised("steady speeds, both ways", ("F_C", "F_S", "v_s", "sigma2"), speeds, (), period, max(50.0, 100 / period),
                  "the friction curve, over a decade on either side of v_s; both ways, so that a zero is not taken for friction"),
        Advised("reversals", ("F_S", "sigma1", "sensor_delay", "direction_asymmetry"), (stribeck, 10 * stribeck), (), SECONDS, crossing,
                  "break-away and what happens about rest; so fast sampled that the bend has some samples"),
        Advised("small strokes", ("sigma0", "sigma1"), (), strokes, STROKES * STROKE / stroke_rate, stroke_rate,
                   "spring, yielding and break-away; a position sensor that resolves a tenth of the shortest is needed"),
        Advised("one of these once more, at the end", ("sensor_drift", "friction_wear"), (stribeck,), (), period, max(50.0, 100 / period),
                  "whether anything changed while you measured", 1),
    )  # fmt: skip


def _value(values: Mapping[str, float | str], name: str) -> float:
    return float(values.get(name, kernel.variable(name).start))
