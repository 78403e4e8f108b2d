"""How is the component run as a Model? What identification and diagnosis talk to; they know no more of it than model.py says."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from evat.model import FloatArray, Rival, Run, Trace, Variable
from evat.native import kernel
from evat.native.batch import run_many
from evat.required_inputs import (
    AMPLITUDES,
    KINEMATICS,
    LAW,
    MOTION,
    check_inputs_of_law,
    check_required_inputs,
    inputs_the_law_lacks,
    missing_inputs,
)

# Internal steps, far beyond what a sound set takes; a holder that chatters against a rigid law takes thousands.
MOST_STEPS, STEPS_PER_SAMPLE, STEPS_PER_CYCLE = 2_000, 8, 120
SPINDLE = "run_out.spindle_frequency"
SETTLING_TIME = 1.0  # s of steady slip, far beyond any presliding; means are taken over the second half


class ContactModel(kernel.ContactTables):
    """The contact with its laws and effects as a `Model`: what `identify` and `diagnose` are given.

    Parameters
    ----------
    threads : int, optional
        How many may be used side by side; without it as many as there are processors. The answer does not depend on it.

    Examples
    --------
    >>> import evat
    >>> model = evat.ContactModel()
    >>> len(model.effects) == len(evat.effects())
    True
    >>> model.effects = tuple(effect for effect in model.effects if effect.name == "dwell_strengthening")  # the only candidate now
    """

    def __init__(self, threads: int | None = None) -> None:
        super().__init__()
        self.threads = threads

    @property
    def digest(self) -> str:
        """The token of the kernel's tables, which is that of the FMUs, too."""
        return kernel.token()

    def simulate(self, run: Run, on: Sequence[str], values: Mapping[str, float | str]) -> Trace:
        """Drive the contact through `run`; see evat.model.Model."""
        values = kernel.in_si(values)
        first = {name: float(column[0]) for name, column in run.inputs.items() if np.size(column) and math.isfinite(column[0])}
        contact = kernel.Contact({**values, **first}, on)
        check_required_inputs(self, on, values, run.inputs)
        check_inputs_of_law(self, kernel.laws(), values, run.inputs)
        contact.start(float(run.times[0]))
        names = list(run.outputs) or list(kernel.outputs())
        table = contact.run(run.times, run.inputs, names)
        return Trace(
            times=np.asarray(run.times, dtype=np.float64),
            columns={name: table[:, place].copy() for place, name in enumerate(names)},
            units={name: kernel.variable(name).unit for name in names},
            made_by={
                "evat": importlib.metadata.version("evat"),
                "model": self.digest,
                "values": dict(values),
                "effects": ", ".join(on),
                "internal_steps": int(contact.get("step_count")),
                "warnings": "; ".join(contact.warnings()),
            },
        )

    def simulate_many(self, run: Run, on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """K value sets through one run; see evat.model.Model."""
        values = kernel.in_si(values)
        cycles = float(run.times[-1] - run.times[0]) * self._highest_frequency(values, on)
        most = MOST_STEPS + STEPS_PER_SAMPLE * run.times.size + STEPS_PER_CYCLE * cycles
        return run_many(run, values, on, threads=self.threads, most_steps=most).rows

    def settled(self, names: Sequence[str], on: Sequence[str], values: Mapping[str, float | str | FloatArray]) -> Mapping[str, FloatArray]:
        """Cycle means of the periodic motion, or of steady slip; see evat.model.Model."""
        if self._moves_by_itself(values):
            periods = 1 / np.atleast_1d(np.asarray(values.get("vibration_frequency", kernel.variable("vibration_frequency").start), float))
            still: dict[str, float | str] = {"initial_state": "periodic"}
        else:
            periods = np.array([SETTLING_TIME])
            still = {"averaging_window": SETTLING_TIME / 2}
        count = max([np.size(value) for value in values.values() if np.ndim(value) == 1], default=1)
        outputs = {name: np.full(count, np.nan) for name in names}
        periods = np.broadcast_to(periods, count)
        for period in np.unique(periods):  # sets share a clock where they share a period
            places = np.flatnonzero(periods == period)
            chosen = {name: np.asarray(value, dtype=np.float64)[places] if np.ndim(value) == 1 else value for name, value in values.items()}
            run = Run(np.array([0.0, period]), {}, tuple(names))
            rows = self.simulate_many(run, on, {**chosen, **still})  # a subclass may run it elsewhere
            for name in names:
                outputs[name][places] = rows[name][:, -1]
        return outputs

    def cycle_time(self, values: Mapping[str, float | str]) -> float:
        """The vibration's period; nan where the motion is given from outside, and where the tool does not vibrate."""
        still = all(float(values.get(name, kernel.variable(name).start)) == 0 for name in AMPLITUDES)
        if still or not self._moves_by_itself(values):
            return math.nan
        return self._period(values)

    def rival_laws(self, values: Mapping[str, float | str]) -> Sequence[Rival]:
        """The other friction laws for which a slip velocity is enough, and whose force follows their parameters without jumps: from the
        slopes of one that has events of its own no fit finds its way. What the kinematics computes from the cut need not be given."""
        known, motion = kernel.variable(LAW), kernel.variable(KINEMATICS)
        own = known.choices[int(known.check(values.get(LAW, known.start)))]
        kinematics = motion.choices[int(motion.check(values.get(KINEMATICS, motion.start)))]

        def is_there(read: Variable) -> bool:
            return read.causality == "parameter" or bool(read.required_with and kinematics not in read.required_with)

        return tuple(
            Rival(
                f"{LAW}={law.name}",
                {LAW: law.name},
                (*(read for read in law.reads if read.causality == "parameter"), *law.variables),
                law.meaning,
            )
            for law in kernel.laws()
            if law.name != own and not law.has_event and all(is_there(read) for read in law.reads)
        )

    def missing_inputs(self, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str]) -> Mapping[str, Sequence[str]]:
        lacking = missing_inputs(self, on, values, given)
        law, inputs = inputs_the_law_lacks(self, kernel.laws(), values, given)
        for name in (read.name for read in inputs):
            lacking.setdefault(name, []).append(f"{LAW} = {law}")
        return lacking

    def _highest_frequency(self, values: Mapping[str, float | str | FloatArray], on: Sequence[str]) -> float:
        """Of what moves by itself [Hz]: the tool, where it vibrates at all, and a spindle that runs out; 0 where nothing does."""
        vibrates = self._moves_by_itself(values) and any(np.any(values.get(name, kernel.variable(name).start)) for name in AMPLITUDES)
        turns = values.get(SPINDLE, kernel.variable(SPINDLE).start) if SPINDLE.partition(".")[0] in on else 0.0
        return max(1 / self._period(values) if vibrates else 0.0, float(np.max(np.asarray(turns, dtype=np.float64))))

    @staticmethod
    def _period(values: Mapping[str, float | str | FloatArray]) -> float:
        """Of the vibration [s], whatever its amplitudes; the shortest, where several sets differ in it."""
        return 1 / float(
            np.max(np.asarray(values.get("vibration_frequency", kernel.variable("vibration_frequency").start), dtype=np.float64))
        )

    @staticmethod
    def _moves_by_itself(values: Mapping[str, float | str | FloatArray]) -> bool:
        known = kernel.variable(KINEMATICS)
        chosen = known.choices[int(known.check(values.get(KINEMATICS, known.start)))]  # type: ignore[arg-type]
        return chosen not in kernel.variable(MOTION).required_with
