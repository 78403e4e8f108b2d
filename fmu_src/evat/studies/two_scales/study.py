"""What does averaging = cycle cost, and how wrong is it, beside the run that follows every cycle? Over one cut, in turns."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.model import FloatArray, ParameterError
from evat.native.kernel import Contact

FORCES = ("friction", "principal", "feed")
MODES = ("resolved", "cycle")


@dataclass(frozen=True)
class TwoScales:
    """Both modes over the same steps. `means[mode]`: mean forces of each step [N], shape (n, 3), in the order of FORCES; `said`: what
    averaging_error says of each step [N]; by mode the processor time of the whole cut, the least of the rounds, and its internal steps."""

    times: FloatArray
    speed: FloatArray
    means: Mapping[str, FloatArray]
    said: FloatArray
    seconds: Mapping[str, float]
    internal_steps: Mapping[str, float]

    @property
    def error(self) -> FloatArray:
        """Largest error of the three mean forces in each step [N]."""
        return np.asarray(np.abs(self.means["cycle"] - self.means["resolved"]).max(axis=1))

    @property
    def largest(self) -> float:
        """Largest mean force of any step [N]."""
        return float(np.abs(self.means["resolved"]).max())

    @property
    def relative_error(self) -> float:
        """Largest error of any step over the largest mean force."""
        return float(self.error.max()) / self.largest

    @property
    def typical_error(self) -> float:
        """Error that half of the steps stay below, over the largest mean force."""
        return float(np.median(self.error)) / self.largest

    @property
    def cheaper(self) -> float:
        """How many times cheaper averaging is."""
        return self.seconds["resolved"] / self.seconds["cycle"]


def changing_speed(times: FloatArray) -> FloatArray:
    """Cutting speed [m/s] of the cut that is shown: 10 to 25 m/min over 2 s, wavering, with one jump, as of a spindle that is set anew."""
    return np.asarray((10 + 5 * times + 2 * np.sin(2 * np.pi * 3 * times) + 4 * (times > 1.2505)) / 60)


def compare(
    times: FloatArray,
    speed: FloatArray,
    values: Mapping[str, float | str] | None = None,
    on: Sequence[str] = (),
    *,
    rounds: int = 1,
) -> TwoScales:
    """Run the cut in both modes.

    Parameters
    ----------
    times : communication points [s]. speed : cutting speed at them [m/s], straight in between.
    values, on : of the contact, SI, and effects that are on.
    rounds : how often each is run, for a time that others on the machine do not disturb.
    """
    times, speed = np.asarray(times, dtype=np.float64), np.asarray(speed, dtype=np.float64)
    if times.shape != speed.shape or times.size < 2:
        raise ParameterError(f"times have the shape {times.shape}, speeds {speed.shape}; two rows of one length, at least 2, are needed.")
    names = (*(f"{name}_impulse" for name in FORCES), "averaging_error", "step_count")
    runs: dict[str, FloatArray] = {}
    seconds = dict.fromkeys(MODES, np.inf)
    for _ in range(rounds):
        for mode in MODES:
            contact = Contact({"cutting_speed": float(speed[0]), **(values or {}), "averaging": mode}, on)
            contact.start(float(times[0]))
            begin = time.process_time()
            runs[mode] = contact.run(times, {"cutting_speed": speed}, names)
            seconds[mode] = min(seconds[mode], time.process_time() - begin)
    means = {mode: np.asarray(np.diff(rows[:, :3], axis=0) / np.diff(times)[:, None]) for mode, rows in runs.items()}
    steps = {mode: float(rows[-1, 4]) for mode, rows in runs.items()}
    return TwoScales(times, speed, means, runs["cycle"][1:, 3], {mode: float(second) for mode, second in seconds.items()}, steps)
