"""How well does each single effect fit an experiment, with no more than least squares? What all baselines share.

Repeats are averaged; noise is taken as white, from the scatter between them. Every effect starts from the best of some random values of its
parameters (the base values re-fitted linearly to each), and all values are then fitted by Levenberg's and Marquardt's method with the prior
of the owner.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from evat.experiment import Experiment, Trial
from evat.inference.prediction import Prediction
from evat.model import EvatError, Model
from radau import Array
from scene import Flags

TRIES, ROUNDS = 16, 6
DEFAULT_SD = 0.1


@dataclass(frozen=True)
class Fit:
    """values: what was fitted; residual: in standard deviations of the noise, at all data; told: number of values fitted."""

    on: tuple[str, ...]
    values: dict[str, float]
    residual: Array
    told: int

    def squares(self, at: Flags) -> float:
        return float(np.sum(self.residual[at] ** 2))


class Bench:
    """An experiment before a model: data over noise, free values, and fits to any part of the conditions."""

    def __init__(self, experiment: Experiment, model: Model) -> None:
        scatter = _scatter(experiment)
        experiment, repeats = _averaged(experiment)
        self.prediction, self.experiment, self.model = Prediction(model, experiment), experiment, model
        self.sigma = _noise(experiment, self.prediction, scatter, repeats)
        nominal, sd = self.prediction.nominal, experiment.nominal.relative_sd
        varied = {name for trial in experiment.trials for name in trial.values} | set(experiment.means.values if experiment.means else ())
        real = {v.name: v for v in model.variables if v.type == "real"}
        numbers = {k: float(v) for k, v in nominal.items() if k in real and not isinstance(v, str) and k not in varied}
        free = [k for k, v in numbers.items() if v > 0 and real[k].variability == "tunable"]
        self.sd = {k: sd.get(k, DEFAULT_SD) * numbers[k] for k in free if sd.get(k, DEFAULT_SD) > 0}
        self.nominal = {k: numbers[k] for k in self.sd}
        self.effects = {e.name: tuple(v for v in e.variables) for e in model.effects if e.name not in experiment.nominal.effects}
        conditions = experiment.conditions
        self.held_out = conditions[1::3] if len(conditions) > 2 else conditions[-1:]
        ordered = sorted(self.prediction.segments, key=lambda s: s.at.start)
        self.condition = np.concatenate([np.full(s.at.stop - s.at.start, conditions.index(s.condition)) for s in ordered])
        self.test = np.isin(self.condition, [conditions.index(c) for c in self.held_out])
        self.all = np.ones(self.condition.size, dtype=bool)

    def residual(self, values: dict[str, float], on: Sequence[str]) -> Array:
        return np.asarray((self.prediction.measured - self.prediction.one(values, on)) / self.sigma)

    def base(self, at: Flags) -> Fit:
        return self._polish((), dict(self.nominal), list(self.nominal), at)

    def nominal_fit(self) -> Fit:
        return Fit((), dict(self.nominal), self.residual(dict(self.nominal), ()), 0)

    def with_effect(self, name: str, base: Fit, at: Flags, rng: np.random.Generator) -> Fit | None:
        """The best fit beside what `base` has; None where the effect cannot run here, or says nothing."""
        own = self.effects[name]
        on = (*base.on, name)
        try:
            start = self._start(name, base, at, rng)
            if start is None:
                return None
            return self._polish(on, {**base.values, **start}, [*base.values, *(v.name for v in own)], at)
        except EvatError:
            return None

    def _start(self, name: str, base: Fit, at: Flags, rng: np.random.Generator) -> dict[str, float] | None:
        own = self.effects[name]
        free = list(base.values)
        _, J = self._jacobian(base.values, free, base.on)
        J = J[at]
        scale = np.sqrt(np.sum(J * J, axis=0)) + 1e-12
        Q, _ = np.linalg.qr(J / scale)
        table = {}
        for v in own:
            middle = v.neutral if np.isfinite(v.neutral) else 0.0
            drawn = middle + (v.start - middle) * np.exp(rng.uniform(-4, 4, TRIES))
            drawn = np.where(rng.random(TRIES) < 0.5, drawn, 2 * middle - drawn) if v.min < 0 else drawn
            table[v.name] = np.clip(drawn, v.min, v.max)
        rows = self.prediction.many({**base.values, **table}, (*base.on, name))
        best, chosen = np.inf, -1
        plain = self.prediction.one(base.values, base.on)
        for k, row in enumerate(rows):
            change = ((row - plain) / self.sigma)[at]
            if not np.all(np.isfinite(change)) or float(change @ change) < 1e-6:
                continue
            r = base.residual[at] - change
            r = r - Q @ (Q.T @ r)
            if float(r @ r) < best:
                best, chosen = float(r @ r), k
        return None if chosen < 0 else {n: float(column[chosen]) for n, column in table.items()}

    def _scales(self, values: dict[str, float]) -> dict[str, float]:
        starts = {v.name: abs(v.start) or 1.0 for own in self.effects.values() for v in own}
        return {n: self.sd.get(n, 0.1 * abs(x) or 0.1 * starts.get(n, 1.0)) for n, x in values.items()}

    def _jacobian(self, values: dict[str, float], free: list[str], on: Sequence[str]) -> tuple[Array, Array]:
        scales = self._scales(values)
        at, J = self.prediction.jacobian(values, free, scales, on)
        return np.asarray((self.prediction.measured - at) / self.sigma), np.nan_to_num(J / self.sigma[:, None])

    def _away(self, values: dict[str, float], free: list[str], scales: dict[str, float]) -> tuple[Array, Array]:
        """Rows of the prior: how far from what the owner believes, and its slope."""
        sd = np.array([self.sd.get(n, np.inf) for n in free])
        here = np.array([(values[n] - self.nominal.get(n, values[n])) for n in free])
        return here / sd, np.diag(np.array([scales[n] for n in free]) / sd)

    def _polish(self, on: tuple[str, ...], values: dict[str, float], free: list[str], at: Flags) -> Fit:
        bounds = {v.name: v for v in self.model.variables}
        damping, scales = 1e-3, self._scales(values)
        r, J = self._jacobian(values, free, on)
        prior, slope = self._away(values, free, scales)
        cost = float(np.sum(r[at] ** 2) + prior @ prior)
        for _ in range(ROUNDS):
            A = J[at].T @ J[at] + slope.T @ slope
            b = J[at].T @ r[at] - slope.T @ prior
            step = np.linalg.solve(A + damping * (np.diag(np.diag(A)) + 1e-9 * np.trace(A) * np.eye(len(free)) + 1e-30), b)
            step = np.clip(step, -5, 5)
            trial = {n: float(np.clip(values[n] + s * scales[n], bounds[n].min, bounds[n].max)) for n, s in zip(free, step, strict=True)}
            r_trial = self.residual(trial, on)
            prior_trial, _ = self._away(trial, free, scales)
            tried = float(np.sum(r_trial[at] ** 2) + prior_trial @ prior_trial)
            if not tried < cost:
                damping *= 10
                if damping > 1e4:
                    break
                continue
            settled = cost - tried < 1e-4 * cost
            values, damping, cost, scales = trial, max(damping / 10, 1e-9), tried, self._scales(trial)
            if settled:
                break
            r, J = self._jacobian(values, free, on)
            prior, slope = self._away(values, free, scales)
        return Fit(on, values, self.residual(values, on), len(free))


def _repeats(experiment: Experiment) -> list[list[Trial]]:
    """Trials of one condition and one clock, together."""
    groups: dict[tuple[str, int], list[Trial]] = {}
    for trial in experiment.trials:
        groups.setdefault((trial.condition, trial.times.size), []).append(trial)
    return list(groups.values())


def _averaged(experiment: Experiment) -> tuple[Experiment, list[int]]:
    """One trial for each group of repeats, and how many they were."""
    groups = _repeats(experiment)
    trials = []
    for group in groups:
        inputs = {name: np.mean([trial.inputs[name] for trial in group], axis=0) for name in group[0].inputs}
        outputs = {name: np.mean([trial.outputs[name] for trial in group], axis=0) for name in group[0].outputs}
        trials.append(replace(group[0], inputs=inputs, outputs=outputs))
    return replace(experiment, trials=tuple(trials)), [len(group) for group in groups]


def _scatter(experiment: Experiment) -> dict[str, float]:
    """Variance between repeats, per channel."""
    variances: dict[str, list[float]] = {}
    for group in _repeats(experiment):
        for channel in group[0].outputs if len(group) > 1 else ():
            variances.setdefault(channel, []).append(float(np.mean(np.var([trial.outputs[channel] for trial in group], axis=0, ddof=1))))
    return {channel: float(np.mean(values)) for channel, values in variances.items()}


def _noise(experiment: Experiment, prediction: Prediction, scatter: dict[str, float], repeats: list[int]) -> Array:
    """Standard deviation of every averaged number: from the scatter between repeats; of means as stated."""
    sigma = np.ones(prediction.measured.size)
    for segment in prediction.segments:
        if segment.trial >= 0:
            sigma[segment.at] = np.sqrt(scatter.get(segment.channel, 1.0) / repeats[segment.trial])
        elif experiment.means is not None:
            row = experiment.means.conditions.index(segment.condition)
            stated = experiment.means.sd.get(segment.channel)
            sigma[segment.at] = stated[row] if stated is not None else 0.05 * np.std(experiment.means.outputs[segment.channel])
    return np.maximum(sigma, 1e-300)
