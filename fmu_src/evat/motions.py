"""How is a contact moved so that its parameters show? Test motions of a rig for orthogonal cutting or friction, one for each condition.

A motion is scaled by the contact: speeds by those of a test, strokes by the distance z = max(F_C, F_S)/sigma0 over which bristles bend.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from evat.model import FloatArray, ParameterError

Kind = Literal["ramp", "steps", "reversal", "presliding", "temperature", "heated_presliding"]
KINDS: tuple[Kind, ...] = get_args(Kind)

ACCELERATION, PLATEAU = 2.0, 1.0  # s: from rest to a test speed, and at it
LEVELS = (1.0, 0.5, 1.0, 0.25, 0.75)  # shares of a test speed that `steps` jumps between
SWINGS = 3  # to and fro, in `reversal`
SWING = 2.0  # s
STROKES = 5
STROKE = 200  # samples
AMPLITUDES = (0.3, 1.0, 3.0)  # of strokes, in bristle lengths z: spring, yielding, break-away


@dataclass(frozen=True, slots=True)
class Motion:
    """One condition: times [s] and inputs at them, shape (n,), SI; `values` are the component's parameters and constant inputs in it."""

    condition: str
    times: FloatArray
    inputs: Mapping[str, FloatArray]
    values: Mapping[str, float]


def _motion(condition: str, velocity: FloatArray, rate: float, values: Mapping[str, float], **more: FloatArray) -> Motion:
    return Motion(condition, np.arange(velocity.size) / rate, {"slip_velocity": velocity, **more}, values)


def _seconds(duration: float, rate: float) -> FloatArray:
    """Sample times of a piece that long, its end left to the next piece."""
    return np.arange(max(2, round(duration * rate))) / rate


def _strokes(amplitude: float, rate: float) -> FloatArray:
    """Slip velocity of sinusoidal strokes of that amplitude [m] about where they start."""
    phase = 2 * np.pi * np.arange(STROKES * STROKE) / STROKE
    return amplitude * 2 * np.pi * rate / STROKE * np.cos(phase)


def _swings(speed: float, rate: float) -> FloatArray:
    """Slip velocity that swings between +speed and -speed along straight lines, from rest to rest. Where it reverses at a sample it is just
    0 there: which way a rounding error slips would be anybody's guess."""
    at = _seconds(SWINGS * SWING, rate) / SWING
    return speed * np.round(4 * np.abs((at - 0.25) % 1 - 0.5) - 1, 12)


def ramp(speeds: Sequence[float], rate: float) -> list[Motion]:
    """The paper's tests: from rest at constant acceleration to a test speed [m/s], then constant; forces are read all the way."""
    motions = []
    for place, speed in enumerate(speeds):
        velocity = np.concatenate([_seconds(ACCELERATION, rate) * speed / ACCELERATION, np.full(round(PLATEAU * rate) + 1, speed)])
        motions.append(_motion(f"speed {place + 1}", velocity, rate, {"cutting_speed": speed}))
    return motions


def steps(speeds: Sequence[float], rate: float) -> list[Motion]:
    """Jumps between shares of a test speed [m/s], each within one sample."""
    motions = []
    for place, speed in enumerate(speeds):
        levels = [np.full(round(PLATEAU * rate), share * speed) for share in LEVELS]
        motions.append(_motion(f"speed {place + 1}", np.concatenate([np.zeros(1), *levels]), rate, {"cutting_speed": speed}))
    return motions


def reversal(speeds: Sequence[float], rate: float) -> list[Motion]:
    """To and fro between +speed and -speed [m/s], at constant acceleration."""
    return [_motion(f"speed {place + 1}", _swings(speed, rate), rate, {"cutting_speed": speed}) for place, speed in enumerate(speeds)]


def presliding(bristle_length: float, rate: float) -> list[Motion]:
    """Strokes of a few bristle lengths [m] and less, micrometres or below: the contact bends before it slips."""
    return [_motion(f"stroke {place + 1}", _strokes(share * bristle_length, rate), rate, {}) for place, share in enumerate(AMPLITUDES)]


def heated(levels: Sequence[float], cold: float, name: str, strokes: Sequence[float], speeds: Sequence[float], rate: float) -> list[Motion]:
    """Strokes of amplitudes [m] while cold; then, heated to a level of the input `name`, the strokes again, and swings to speeds [m/s]."""
    stroke = np.concatenate([_strokes(amplitude, rate) for amplitude in strokes])
    motions = []
    for place, level in enumerate(levels):
        velocity = np.concatenate([stroke, stroke, *(_swings(speed, rate) for speed in speeds)])
        heat = np.full(velocity.size, level)
        heat[: stroke.size] = cold
        motions.append(_motion(f"temperature {place + 1}", velocity, rate, {}, **{name: heat}))
    return motions


def check_speeds(speeds: Sequence[float]) -> None:
    """ParameterError where these are no test speeds."""
    if not speeds or not all(0 < speed <= 100 for speed in speeds):
        raise ParameterError(f"test speeds {list(speeds)} m/s: at least one is needed, each above 0 and at most 100.")
