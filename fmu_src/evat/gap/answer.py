"""What does a diagnosis say? All of it as one value, and as the JSON that other programs read."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from evat.constants import CONSTANTS
from evat.gap.advise import Advice
from evat.gap.closure import Closure
from evat.gap.location import Location
from evat.gap.next_step import RECORDED, Step, next_step
from evat.gap.set_up import SetUpError
from evat.gap.values_alone import ValuesAlone
from evat.gap.verdict.gates import Gate
from evat.gap.verdict.judgement import Judgement
from evat.gap.verdict.small import SmallEffect
from evat.inference.hypothesis import Hypothesis
from evat.inference.noise.irregularity import Irregularity
from evat.model import ShownAsTable

FORMAT = 1


@dataclass(frozen=True)
class Named:
    """An effect of the answer, or another base law: `parameters[name]` are value, sd and unit; these data cannot tell it from those
    that it is `not_separable_from`."""

    name: str
    probability: float
    parameters: Mapping[str, tuple[float, float, str]]
    not_separable_from: tuple[str, ...]
    is_law: bool = False


class Novelty(NamedTuple):
    """How likely these candidates are all that acts, and the share of the gap that the chosen ones leave."""

    p_value: float
    unexplained_share: float


@dataclass(frozen=True)
class Recalibrated:
    """`parameters[name]`: nominal value, recalibrated value, sd; `explains_share`: of the nominal structural gap, with the set-up;
    `setup[channel][kind]`: gain, zero and clock that all trials share, each with value, sd and unit; `notable` are those of them that
    take up most of the gap in a channel; `with_effects[name]`: value and sd of the same parameters beside the effects that are named."""

    parameters: Mapping[str, tuple[float, float, float]]
    explains_share: float
    setup: Mapping[str, Mapping[str, tuple[float, float, str]]]
    notable: tuple[SetUpError, ...] = ()
    with_effects: Mapping[str, tuple[float, float]] = field(default_factory=dict)


@dataclass(frozen=True, repr=False)
class Diagnosis(ShownAsTable):
    """Why measurement and nominal model disagree, as far as the data tell: what `evat.diagnose` gives.

    Attributes
    ----------
    verdict : str
        no_gap, mistuned, effect, ambiguous, unknown or cannot_tell.
    effects : tuple of Named
        The effects and base laws that are named: `name`, `probability`, `parameters` (name -> value, sd, unit), and
        `not_separable_from`, which cannot be told from it.
    judgement : Judgement
        What was judged, and the probabilities of all hypotheses.
    gates : tuple of Gate
        The questions that led to the verdict, in order, each with its numbers and whether it moved the verdict.
    novelty : Novelty
        `p_value` that something unknown acts, and `unexplained_share`, that of the nominal model's gap that is left beside what the answer
        names: recalibrated values, set-up and effects.
    recalibration : Recalibrated
        Nominal and recalibrated values (name -> nominal, value, sd), the share of the gap that they explain, and set-up errors.
    where : Location
        Where the gap lies: shares of its square by channel and trial, and the regions that hold most of it.
    closure : Closure
        How far the gap closes, with its 90 % interval, on conditions that were left out of the fit; root mean squares of each channel, in
        its unit, as the set-up shows the models, and `values_alone` by the values alone that corrected.ssv holds.
    cannot_tell : tuple of str
        What these data leave open, in sentences.
    advice : Advice or None
        The experiment that would tell the two likeliest causes apart, whether or not that is what is to be done next.
    made_by : mapping of str to str or float
        Versions, and digests of model and data.
    families : mapping of str to float
        Probability that an effect of each family acts, the likeliest first.
    members : mapping of str to tuple of str
        The effects of each family.
    small_effect : SmallEffect or None
        What is certain and yet small.
    foreign : mapping of str to Irregularity
        By channel, what comes and goes by itself and is more than the effects explain.
    later : str
        Where samples that were not looked at leave more than those that were, a sentence of that.
    shifted : tuple of str
        Nominal values that are further off than their owner can have meant, a sentence each.

    Examples
    --------
    A contact whose friction is a little off the nominal value, and no effect:

    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 8.0}, motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=50.0)
    >>> model = evat.ContactModel()
    >>> model.effects = tuple(each for each in model.effects if each.name == "direction_asymmetry")
    >>> answer = evat.diagnose(made, model)
    >>> answer.verdict, answer.effects, [gate.name for gate in answer.gates if gate.moved]
    ('mistuned', (), ['structural_gap', 'nominal_fits', 'nominal_suffices'])
    >>> answer.document()["format"]
    1
    """

    verdict: str
    effects: tuple[Named, ...]
    judgement: Judgement
    gates: tuple[Gate, ...]
    novelty: Novelty
    recalibration: Recalibrated
    where: Location
    closure: Closure
    cannot_tell: tuple[str, ...]
    advice: Advice | None
    made_by: Mapping[str, str | float]
    families: Mapping[str, float] = field(default_factory=dict)
    members: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    small_effect: SmallEffect | None = None
    foreign: Mapping[str, Irregularity] = field(default_factory=dict)
    later: str = ""
    shifted: tuple[str, ...] = ()

    @property
    def next_step(self) -> Step:
        """What is to be done next: one of the steps of evat.gap.next_step."""
        return next_step(
            self.verdict,
            self.judgement,
            self.closure,
            set_up=bool(self.recalibration.notable),
            later=bool(self.later),
            foreign=bool(self.foreign),
            far=bool(self.shifted),
        )

    @property
    def next_experiment(self) -> Advice | None:
        """What was advised, where a condition is to be recorded next."""
        return self.advice if self.next_step in RECORDED else None

    @property
    def candidates(self) -> tuple[tuple[Hypothesis, float | None], ...]:
        """Hypotheses that are not out of the question, the likeliest first, with their probabilities to six digits."""
        ranked = sorted(self.judgement.probabilities.items(), key=lambda item: (-item[1], item[0]))
        return tuple((on, _number(probability)) for on, probability in ranked if probability > CONSTANTS.least_candidate)

    def document(self) -> dict[str, Any]:
        """As diagnosis.json."""
        return {
            "format": FORMAT,
            "verdict": self.verdict,
            "effects": [
                {
                    "name": effect.name,
                    "probability": _number(effect.probability),
                    "parameters": {
                        name: {"value": _number(value), "sd": _number(sd), "unit": unit}
                        for name, (value, sd, unit) in effect.parameters.items()
                    },
                    "not_separable_from": list(effect.not_separable_from),
                }
                for effect in self.effects
            ],
            "candidates": [{"set": list(on), "probability": probability} for on, probability in self.candidates],
            "families": [{"name": name, "probability": _number(p)} for name, p in self.families.items() if p > CONSTANTS.least_candidate],
            "small_effect": None
            if self.small_effect is None
            else {
                "either": [list(on) for on in self.small_effect.either],
                "channel": self.small_effect.channel,
                "share_of_rms": _number(self.small_effect.share_of_rms),
                "log_evidence": _number(self.small_effect.log_evidence),
            },
            "gates": [gate.document() for gate in self.gates],
            "novelty": {"p_value": _number(self.novelty.p_value), "unexplained_share": _number(self.novelty.unexplained_share)},
            "recalibration": {
                "parameters": {
                    name: {"nominal": _number(nominal), "value": _number(value), "sd": _number(sd)}
                    for name, (nominal, value, sd) in self.recalibration.parameters.items()
                },
                "with_effects": {
                    name: {"value": _number(value), "sd": _number(sd)} for name, (value, sd) in self.recalibration.with_effects.items()
                },
                "explains_share": _number(self.recalibration.explains_share),
                "closed_share": _share(self.closure.by_recalibration),
            },
            "setup": {
                channel: {kind: {"value": _number(value), "sd": _number(sd), "unit": unit} for kind, (value, sd, unit) in errors.items()}
                for channel, errors in self.recalibration.setup.items()
            },
            "where": {
                "channels": {name: _number(value) for name, value in self.where.channels.items()},
                "regions": [
                    {
                        "channel": region.channel,
                        "box": {name: [_number(low), _number(high)] for name, (low, high) in region.box.items()},
                        "share": _number(region.share),
                    }
                    for region in self.where.regions
                ],
                "trials": {name: _number(value) for name, value in self.where.trials.items()},
            },
            "gap": {
                "unit": self.closure.unit,
                "channels": {channel: {name: _number(value) for name, value in row.items()} for channel, row in self.closure.rms.items()},
                "closed_share": _share((self.closure.closed_share, self.closure.interval)),
                "held_out_conditions": list(self.closure.held_out_conditions),
                "closed_share_where_fitted": _share(self.closure.closed_share_where_fitted),
                # As corrected.ssv holds them: no form that no law has, and no set-up, no start of a recording, or both put right.
                "values_alone": _left(self.closure.values_alone),
                "values_with_set_up": _left(self.closure.values_with_set_up),
            },
            "cannot_tell": list(self.cannot_tell),
            "next_step": self.next_step,
            "next_experiment": None
            if self.next_experiment is None
            else {
                "condition": self.next_experiment.condition,
                "values": {name: _number(value) for name, value in self.next_experiment.values.items()},
                "separates": [["+".join(on) or "none" for on in self.next_experiment.separates]],
                "expected_probability": _number(self.next_experiment.expected_probability),
            },
            "made_by": {name: _number(value) if isinstance(value, float) else value for name, value in self.made_by.items()},
        }

    def _table(self) -> Any:
        from evat.notebook.tables import ResultTable

        rows = [(" + ".join(on) or "none", "" if p is None else f"{100 * p:.1f} %") for on, p in self.candidates]
        (share, (low, high)), where = (self.closure.closed_share, self.closure.interval), ""
        if not self.closure.held_out_conditions:
            (share, (low, high)), where = self.closure.closed_share_where_fitted, " of conditions that it was fitted to"
        interval = f", 90 % interval {100 * low:.0f} to {100 * high:.0f} %" if math.isfinite(low) else ""
        closed = f"closes {100 * share:.0f} % of the gap{where}{interval}" if math.isfinite(share) else ""
        return ResultTable(f"Diagnosis: {self.verdict}", ("effects", "probability"), rows, (closed, *self.cannot_tell))

    def json(self) -> str:
        return json.dumps(self.document(), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _left(values: ValuesAlone) -> dict[str, Any]:
    return {
        "channels": {channel: {name: _number(value) for name, value in row.items()} for channel, row in values.rms.items()},
        "closed_share": _number(values.closed_share),
    }


def _share(known: tuple[float, tuple[float, float]]) -> dict[str, Any]:
    return {"value": _number(known[0]), "ci90": [_number(end) for end in known[1]]}


def _number(value: float) -> float | None:
    """Six digits; what is not known is null."""
    return float(f"{value:.6g}") if math.isfinite(value) else None
