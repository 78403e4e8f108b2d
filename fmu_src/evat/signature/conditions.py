"""Under which conditions is an effect shown? A fixed list, which knows none by name; signature.py shows those where it shows most."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.model import FloatArray
from evat.signature.runs import DECADES, MEANS, RECORDED, Axis, Case, cycle_means, loop, means_over_time, peak_after_rest, steady

Answers = Mapping[Axis, FloatArray]
_share = np.linspace(0.1, 2, 20)


@dataclass(frozen=True, slots=True)
class Condition:
    """What is varied, and what comes out: answers(case) -> places along `across`, and the quantities at them."""

    title: str
    across: Axis
    answers: Callable[[Case], tuple[FloatArray, Answers]]


def _swept(
    title: str, across: Axis, ups: Sequence[Axis], places: Callable[[Case], FloatArray], answer: Callable[[Case, float], Sequence[float]]
) -> Condition:
    def answers(case: Case) -> tuple[FloatArray, Answers]:
        at = places(case)
        table = np.array([answer(case, float(place)) for place in at])
        return at, dict(zip(ups, table.T, strict=True))

    return Condition(title, across, answers)


def _timed(
    title: str,
    window: Callable[[Case], float],
    count: int,
    prepared: Callable[[Case, float], Case],
    carried: Callable[[Case], float] = lambda case: 0.0,
) -> Condition:
    def answers(case: Case) -> tuple[FloatArray, Answers]:
        step = window(case)
        ends: FloatArray = np.arange(2, count + 2) * np.float64(step)
        return ends, means_over_time(prepared(case, step), step, count, carried(case))

    return Condition(title, Axis.of("time"), answers)


_recorded, _means = [Axis.of(name) for name in RECORDED], [Axis.of(name) for name in MEANS]
_peak = [Axis("peak of measured friction", "N", "N")]
_loops = [*_peak, Axis("friction energy in a cycle", "J", "mJ")]

CONDITIONS: tuple[Condition, ...] = (
    _swept(
        "vibration, mean over a cycle",
        Axis.of("cutting_speed"),
        _means,
        lambda case: case.fastest * np.linspace(0.04, 1.24, 25),
        lambda case, place: cycle_means(case.but(cutting_speed=place)),
    ),
    _swept(
        "vibration, mean over a cycle",
        Axis.of("feed"),
        _means,
        lambda case: case["feed"] * _share,
        lambda case, place: cycle_means(case.but(feed=place)),
    ),
    _swept(
        "vibration, mean over a cycle",
        Axis.of("proxy_speed"),
        _means,
        lambda case: case["theta_ref"] * np.linspace(1, 40, 20),
        lambda case, place: cycle_means(case.but(proxy_source="proxy_speed", proxy_speed=place)),
    ),
    _timed("vibration, entry: mean over each cycle", lambda case: case.period, 100, lambda case, step: case.on_ellipse("at_rest", step)),
    _timed(
        "vibration, later: mean over each 20 cycles",
        lambda case: 20 * case.period,
        200,
        lambda case, step: case.on_ellipse("at_rest", step),
    ),
    _swept(
        "rig, steady slip",
        Axis.of("slip_velocity", logarithmic=True),
        _recorded,
        lambda case: 100 * case.speed * DECADES,
        lambda case, place: steady(case.but(slip_velocity=place)),
    ),
    _swept(
        "rig, steady slip",
        Axis.of("uncut_thickness"),
        _recorded,
        lambda case: case["uncut_thickness"] * _share,
        lambda case, place: steady(case.but(uncut_thickness=place, slip_velocity=case.speed)),
    ),
    _swept(
        "rig, steady slip",
        Axis.of("normal_load"),
        _recorded,
        lambda case: case["normal_load"] * _share,
        lambda case, place: steady(case.but(normal_load=place, slip_velocity=case.speed)),
    ),
    _swept(
        "rig, slip to and fro",
        Axis("slip amplitude", "m", "um", True),
        _loops,
        lambda case: case.reach * np.geomspace(0.03, 30, 25),
        lambda case, place: loop(case, place, case.speed / (20 * np.pi * case.reach)),
    ),
    _swept(
        "rig, slip to and fro",
        Axis("frequency of the slip", "Hz", "Hz", True),
        _loops,
        lambda case: case["vibration_frequency"] * DECADES,
        lambda case, place: loop(case, 3 * case.reach, place),
    ),
    _swept(
        "rig, slip after a rest",
        Axis("time at rest", "s", "s", True),
        _peak,
        lambda case: np.geomspace(1e-5, 10, 19),
        lambda case, place: peak_after_rest(case, place),
    ),
    _timed(
        "rig, slip of 1 m/s: mean over each window", lambda case: 0.25, 200, lambda case, step: case.on_rig(step).but(slip_velocity=1.0)
    ),
    _timed(
        "vibration, tool carried to and fro: means",
        lambda case: 20 * case.period,
        200,
        lambda case, step: case.carried(step),
        lambda case: 0.1 * case["feed"],
    ),
)
