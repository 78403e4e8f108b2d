"""What does a search for the cause of a gap have to do with, and what came of it so far?"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from evat.gap.search.starts.screen import Screen, Start
from evat.inference.band_whitening import BandWhitening
from evat.inference.fit import Fit, fit
from evat.inference.hypothesis import Hypothesis
from evat.inference.parameters import Parameter, Scales, form_parameters
from evat.inference.prediction import Prediction
from evat.model import Effect, FloatArray, Model

Progress = Callable[[str, float], None]  # what is done now, and which share of the whole is behind it


@dataclass
class Candidates:
    """Hypotheses beside the `recalibrated` model, of effects that are `offered`.

    `models` are those that were fitted; `rough` is the evidence of all that were looked at, as far as they were; `fronts` tell of an effect
    how it starts beside the recalibrated parameters, and from which point (p,) it is fitted. `silent` effects do nothing here, `unfed` ones
    lack inputs.
    """

    prediction: Prediction
    whitening: BandWhitening
    recalibrated: Fit
    offered: Sequence[Effect]
    tell: Progress
    models: dict[Hypothesis, Fit] = field(default_factory=dict)
    rough: dict[Hypothesis, float] = field(default_factory=dict)
    fronts: dict[str, tuple[Start, FloatArray]] = field(default_factory=dict)
    silent: list[str] = field(default_factory=list)
    unfed: dict[str, Sequence[str]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.scales = Scales(self.prediction.model, self.prediction.experiment)
        self.screen = Screen(self.prediction, self.whitening, self.scales)

    @property
    def without_effects(self) -> float:
        """Log evidence of the recalibrated model."""
        return self.recalibrated.likelihood.evidence

    def fit_beside(self, base: Fit, start: Start, point: FloatArray, on: Sequence[str]) -> Fit | None:
        """The best point of an effect beside a fit, near `point` (p,) of the parameters of both; None where the model does not run."""
        shapes = self._shapes_beside(base, start, on)
        whole = np.append(point, np.zeros(len(shapes)))
        fixed = {**base.fixed, **start.fixed}
        return fit(self.prediction, self.whitening, (*base.parameters, *start.parameters, *shapes), whole, on, fixed=fixed)

    def _shapes_beside(self, base: Fit, start: Start, on: Sequence[str]) -> tuple[Parameter, ...]:
        """Shapes of the law that do nothing in the nominal model and something once the effect is there, as a viscous exponent does where
        the nominal model knows no viscous friction: they are as little known then as those of the nominal model."""
        fitted = {parameter.name for parameter in base.parameters}
        idle = [p for p in form_parameters(self.prediction.model, self.prediction.experiment) if p.name not in fitted]
        own = {p.name: p.value(float(u)) for p, u in zip(start.parameters, start.point, strict=True)}
        values, probe = {**base.values, **start.fixed, **own}, self.screen.probe
        as_usual = probe.one(values, on) if idle else np.zeros(0)
        return tuple(p for p in idle if np.any(np.nan_to_num(probe.one({**values, p.name: p.value(1.0)}, on) - as_usual)))


def allowed(model: Model, effects: Sequence[str]) -> bool:
    """May these be on together?"""
    rivals = {effect.name: effect.rivals for effect in model.effects}
    return not any(other in rivals.get(name, ()) for name in effects for other in effects)


def of_one_family(model: Model, on: Hypothesis) -> bool:
    """Whether these are parts of one cause: a chain of sensors is one filter, whichever of its kind the library has for it."""
    own = [effect for effect in model.effects if effect.name in on]
    return len(own) > 1 and len({effect.family for effect in own}) == 1 and any(effect.stage == "measurement" for effect in own)


def best_pairs(model: Model, ranked: Sequence[Hypothesis], most: int) -> list[Hypothesis]:
    """The first pairs of a ranking, and the best of those that are parts of one cause: these tell what the library knows, and are never
    named."""
    parts = [on for on in ranked if of_one_family(model, on)]
    apart = [on for on in ranked if on not in parts][:most]
    return [on for on in ranked if on in apart or on in parts[:1]]
