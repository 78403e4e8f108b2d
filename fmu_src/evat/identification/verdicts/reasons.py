"""Why can these data not tell a parameter? What a friction law says of a motion, one sentence per parameter, each with what is checked.

A sentence is shown only beside the numbers' own verdict (profile, correlation); it explains, it does not decide.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from evat.experiment import Experiment


@dataclass(frozen=True, slots=True)
class RecordFacts:
    """What the slip of an experiment was like; None in `facts` where slip is not an input."""

    reversals: int
    slowest: float
    fastest: float
    presliding: float
    proxy_varies: bool
    v_s: float


def facts(experiment: Experiment, values: Mapping[str, float | str]) -> RecordFacts | None:
    """slowest, fastest : |slip| [m/s] that 5 and 100 % of the moving samples stay below; presliding : share of samples within a break-away
    way of a turn or a start."""
    slips = [(trial, trial.inputs["slip_velocity"]) for trial in experiment.trials if "slip_velocity" in trial.inputs]
    if not slips:
        return None
    way = _number(values, "F_C") / max(_number(values, "sigma0"), 1e-300)
    reversals, within, count, moving = 0, 0, 0, list[np.ndarray]()
    for trial, slip in slips:
        moves = np.flatnonzero(slip != 0)
        signs = np.sign(slip[moves])
        turns = moves[1:][signs[1:] != signs[:-1]]
        reversals += turns.size
        travelled = np.concatenate([[0.0], np.cumsum(np.abs(slip[1:] + slip[:-1]) / 2 * np.diff(trial.times))])
        since = travelled - np.concatenate([[0.0], travelled[turns]])[np.searchsorted(turns, np.arange(slip.size), side="right")]
        within += int(np.sum(since < 3 * way))
        count += slip.size
        moving.append(np.abs(slip[moves]))
    speeds = np.concatenate(moving) if any(row.size for row in moving) else np.zeros(1)
    of_slip = values.get("proxy_source", "slip_speed") == "slip_speed" and speeds.size > 0 and float(np.ptp(speeds)) > 0
    columns = [trial.inputs[name] for trial, _ in slips for name in ("proxy_speed", "contact_temperature") if name in trial.inputs]
    varies = of_slip or any(float(np.ptp(column)) > 1e-3 * float(np.max(np.abs(column), initial=1e-300)) for column in columns)
    return RecordFacts(reversals, float(np.quantile(speeds, 0.05)), float(speeds.max()), within / count, varies, _number(values, "v_s"))


Reason = tuple[Callable[[RecordFacts], bool], str]
NO_TURN: Reason = (
    lambda f: f.reversals == 0,
    "the slip never reverses, and in steady sliding the bristles bear g(v) whatever their stiffness and damping: sigma0 and sigma1 cancel",
)
NO_PRESLIDING: Reason = (
    lambda f: f.presliding < 0.02,
    "hardly a sample lies within a break-away way of a turn, where alone the bristles show",
)
REASONS: Mapping[str, tuple[Reason, ...]] = {
    "sigma0": (NO_TURN, NO_PRESLIDING),
    "sigma1": (NO_TURN, NO_PRESLIDING),
    "F_S": ((lambda f: f.slowest > 2 * f.v_s, "the speeds stay above twice v_s, where friction has come down from F_S to F_C"),),
    "v_s": ((lambda f: f.slowest > 2 * f.v_s, "the speeds stay above twice v_s, where friction no longer falls with speed"),),
    "F_C": ((lambda f: f.fastest < 1.5 * f.v_s, "the speeds stay near or below v_s, where friction has not come down to F_C"),),
    "sigma2": ((lambda f: f.fastest < 1.5 * f.slowest, "there is one speed only, at which viscous and Coulomb friction are one number"),),
}
THERMAL: Reason = (
    lambda f: not f.proxy_varies,
    "the temperature proxy does not vary: neither a proxy speed nor a temperature that varies is among the inputs",
)


def reason(name: str, known: RecordFacts | None) -> str:
    """The sentence that holds for a parameter, "" where none does."""
    if known is None:
        return ""
    own = (THERMAL,) if name.startswith("thermal_") else REASONS.get(name, ())
    return next((sentence for holds, sentence in own if holds(known)), "")


def _number(values: Mapping[str, float | str], name: str) -> float:
    value = values.get(name, 0.0)
    return float(value) if isinstance(value, (int, float)) else 0.0
