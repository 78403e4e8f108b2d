"""Do many sets run at once give what each gives alone, whatever the threads, and does nothing get lost?"""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from evat.model import FloatArray, ParameterError, Run
from evat.native import batch as batches
from evat.native import kernel
from evat.native.batch import Batch, Cancelled, run_many
from evat.native.compile import MANY_LANES, kernel_library_path
from evat.native.kernel import Contact
from evat.native.processor import instructions
from evat.studies.sensitivity import sensitivities
from scipy.integrate import solve_ivp

TIMES: FloatArray = np.arange(300, dtype=np.float64) * 2e-3
SLIP: FloatArray = 0.02 * np.sin(2 * np.pi * 0.7 * TIMES) + 0.01 * np.sin(2 * np.pi * 3.1 * TIMES)
RIG = Run(TIMES, {"slip_velocity": SLIP}, ("friction_force", "bristle_deflection"))
COUNT = 19  # two blocks and a part


def sets(count: int = COUNT) -> dict[str, float | str | np.ndarray]:
    luck = np.random.default_rng(1)
    return {"kinematics": "external", "F_C": luck.uniform(1, 10, count), "sigma0": 10 ** luck.uniform(4, 6, count), "F_S": 8.0}


def one(values: dict[str, float | str | np.ndarray], place: int) -> dict[str, float | str]:
    return {name: float(value[place]) if isinstance(value, np.ndarray) else value for name, value in values.items()}


def alone(values: dict[str, float | str], run: Run, on: tuple[str, ...] = ()) -> np.ndarray:
    contact = Contact({**values, **{name: float(column[0]) for name, column in run.inputs.items()}}, on)
    contact.start(float(run.times[0]))
    return contact.run(run.times, run.inputs, run.outputs)


@pytest.mark.parametrize(
    ("start", "on", "beside"),
    [
        ("periodic", ("amplitude_loss",), False),
        ("periodic", ("maxwell_slip", "holder_compliance"), False),
        ("at_rest", ("amplitude_loss",), True),
        ("periodic", ("maxwell_slip",), True),
    ],
)
def test_searches_of_a_tool_that_forces_move_go_one_by_one(
    start: str, on: tuple[str, ...], beside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside each other all would go on for as long as the longest."""
    lanes = set[int]()
    follow = batches._follow

    def seen(plan: Any, places: Any, count: int, stop: Any) -> Any:
        lanes.add(count)
        return follow(plan, places, count, stop)

    monkeypatch.setattr(batches, "_follow", seen)
    values = {"initial_state": start, "F_C": np.linspace(6, 10, MANY_LANES)}
    assert not run_many(Run(np.array([0.0, 5e-5]), {}, ("mean_feed_force",)), values, on, threads=1).failed
    assert lanes == {MANY_LANES if beside else 1}


STATEFUL = ("elasto_plastic", "dwell_strengthening", "dynamometer_resonance")
FEEDBACK = ("holder_compliance", "sensor_delay")  # with laws that have bristles; others chatter where a compliant tool sticks


@pytest.mark.parametrize(
    ("law", "on"),
    [(law, on) for law in ("lugre", "dahl", "reset_integrator") for on in ((), STATEFUL, FEEDBACK)]
    + [(law, on) for law in ("karnopp", "coulomb") for on in ((), STATEFUL)]
    + [("bristle", ())],
)
def test_a_set_among_others_is_that_set_alone(law: str, on: tuple[str, ...]) -> None:
    """To the last bit."""
    values = {**sets(), "friction_law": law}
    batch = run_many(RIG, values, on)
    assert not batch.failed
    for place in range(COUNT):
        expected = alone(one(values, place), RIG, on)
        for column, name in enumerate(RIG.outputs):
            assert np.array_equal(batch.rows[name][place], expected[:, column])


def test_an_ellipse_among_others_is_that_ellipse_alone() -> None:
    """Sets that differ in the path and in what is fixed: frequency and law."""
    luck, run = np.random.default_rng(2), Run(np.arange(40, dtype=np.float64) * 7e-6, {}, ("principal_force", "mean_feed_force"))
    values: dict[str, float | str | np.ndarray] = {
        "cutting_speed": luck.uniform(0.1, 0.4, 6),
        "vibration_frequency": np.repeat([2e4, 1.7e4], 3),
        "friction_law": np.array([0.0, 1, 1] * 2),
    }
    batch = run_many(run, values)
    for place in range(6):
        assert np.array_equal(batch.rows["principal_force"][place], alone(one(values, place), run)[:, 0])


@pytest.mark.parametrize("kinematics", ["external", "internal"])
def test_every_library_gives_the_same_bits(monkeypatch: pytest.MonkeyPatch, kinematics: str) -> None:
    """Compiled for wider vectors or not: with each instruction that the kernel knows to use taken away."""
    run = Run(TIMES, RIG.inputs if kinematics == "external" else {}, ("principal_force", "bristle_deflection"))
    there, rows_of = instructions(), {}
    for less in (frozenset(), {"AVX512F"}, {"AVX512F", "AVX2"}):
        monkeypatch.setattr(kernel, "instructions", lambda less=less: there - less)
        kernel._loaded.cache_clear()
        batch = run_many(
            Run(run.times * (1 if kinematics == "external" else 1e-3), run.inputs, run.outputs), {**sets(), "kinematics": kinematics}
        )
        rows_of[kernel_library_path(MANY_LANES, there - less).name] = np.stack([batch.rows[name] for name in run.outputs])
    kernel._loaded.cache_clear()
    first, *others = rows_of.values()
    assert np.isfinite(first).all()
    assert all(np.array_equal(first, other) for other in others)


def test_conditions_of_their_own() -> None:
    """One set over many inputs."""
    scale = np.linspace(0.5, 2, COUNT)
    batch = run_many(Run(TIMES, {"slip_velocity": scale[:, None] * SLIP}, ("friction_force",)), {"kinematics": "external"})
    for place in (0, 7, COUNT - 1):
        expected = alone({"kinematics": "external"}, Run(TIMES, {"slip_velocity": scale[place] * SLIP}, ("friction_force",)))
        assert np.array_equal(batch.rows["friction_force"][place], expected[:, 0])


@pytest.mark.parametrize("threads", [1, 2, 5])
def test_threads_do_not_matter(threads: int) -> None:
    values, many = sets(100), run_many(RIG, sets(100), threads=threads)
    first = run_many(RIG, {name: value[:50] if isinstance(value, np.ndarray) else value for name, value in values.items()}, threads=1)
    assert np.array_equal(many.rows["friction_force"][:50], first.rows["friction_force"])


def test_rows_at_a_slower_clock_are_those_of_the_full_one() -> None:
    """Kept on the way, where the clocks meet; between its samples the motion is a straight line."""
    every = run_many(RIG, sets())
    thinned = run_many(RIG, sets(), at=TIMES[::7])
    assert np.array_equal(thinned.rows["friction_force"], every.rows["friction_force"][:, ::7])
    between = run_many(RIG, {**sets(), "relative_tolerance": 1e-9}, at=TIMES[3:-1] + 0.3e-3)
    assert between.times.size == TIMES.size - 4
    neighbours = np.abs(np.diff(every.rows["friction_force"][:, 3:], axis=1)).max()
    assert np.abs(between.rows["friction_force"] - every.rows["friction_force"][:, 3:-1]).max() <= 1.01 * neighbours


def test_sums_are_the_sums_of_the_rows() -> None:
    luck = np.random.default_rng(3)
    data = {"friction_force": np.where(luck.uniform(size=TIMES.size) < 0.2, np.nan, luck.normal(0, 5, TIMES.size))}
    rows, sums = run_many(RIG, sets()), run_many(RIG, sets(), give="sums", data=data)
    assert sums.sums["friction_force"] == pytest.approx(rows.rows["friction_force"].sum(axis=1), rel=1e-12)
    squares = np.nansum((rows.rows["friction_force"] - data["friction_force"]) ** 2, axis=1)
    assert sums.squares["friction_force"] == pytest.approx(squares, rel=1e-12)
    assert sums.counts == {"friction_force": int(np.isfinite(data["friction_force"]).sum()), "bristle_deflection": 0}
    assert not sums.rows


def test_a_set_that_fails_spoils_no_other() -> None:
    """A reference temperature below the ambient one ends its own run only."""
    values = {**sets(), "proxy_source": "contact_temperature", "contact_temperature": 350.0}
    values["reference_temperature"] = np.where(np.arange(COUNT) == 4, 200.0, 400.0)
    batch = run_many(RIG, values)
    assert list(batch.failed) == [4]
    assert "reference_temperature" in batch.failed[4]
    assert np.all(np.isnan(batch.rows["friction_force"][4]))
    assert np.array_equal(batch.rows["friction_force"][5], alone(one(values, 5), RIG)[:, 0])


def test_progress_ends_at_one_and_only_rises() -> None:
    told: list[float] = []
    run_many(RIG, sets(500), give="sums", progress=told.append)
    assert told == sorted(told)
    assert told[-1] == 1


def test_a_batch_can_be_stopped() -> None:
    """Soon: in the midst of runs that would take many seconds, also on a single long one."""
    long = Run(np.arange(2000, dtype=np.float64) * 1e-3, {}, ("friction_force",))
    begun = time.monotonic()
    with pytest.raises(Cancelled):
        run_many(long, {"cutting_speed": np.linspace(0.1, 0.3, 40)}, cancelled=lambda: True)
    assert time.monotonic() - begun < 10  # all of it takes a minute


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"F_C": np.array([1.0, -1.0])}, "F_C = -1"),
        ({"F_C": np.array([1.0, np.nan])}, "finite"),
        ({"F_C": np.ones(2), "F_S": np.ones(3)}, "different numbers of sets"),
        ({"F_C": np.ones((2, 2))}, "shape"),
        ({"no_such": np.ones(2)}, "no_such"),
        ({"friction_law": np.array([0.5, 1.0])}, "whole number"),
    ],
)
def test_bad_sets_are_refused(values: dict[str, float | str | np.ndarray], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        run_many(RIG, values)


def test_bad_runs_are_refused() -> None:
    cases: tuple[tuple[Run, dict[str, Any], str], ...] = (
        (Run(TIMES, {"slip_velocity": SLIP[:-1]}, ("friction_force",)), {}, "shape"),
        (Run(TIMES, {"F_C": SLIP}, ("friction_force",)), {}, "not an input"),
        (Run(TIMES, {}, ()), {}, "no outputs"),
        (Run(TIMES[::-1], {}, ("friction_force",)), {}, "increasing"),
        (RIG, {"at": TIMES + 1}, "outputs are wanted"),
        (RIG, {"data": {"feed_force": TIMES}}, "data need"),
    )
    for run, options, words in cases:
        with pytest.raises(ParameterError, match=words):
            run_many(run, {}, **options)


# ---- sensitivities ----------------------------------------------------------------------------------------------------------------------

SMOOTH: dict[str, float | str] = {
    "kinematics": "external",
    "sigma0": 2e4,
    "sigma1": 3.0,
    "sigma2": 0.7,
    "F_C": 4.0,
    "F_S": 6.0,
    "v_s": 5e-3,
    "damping_mode": "as_published",
}


def friction(values: dict[str, float], times: np.ndarray) -> np.ndarray:
    """LuGre written down again, under a slip of 0.01 (1 + 0.5 sin 40 t), by a solver of its own."""

    def slip(t: np.ndarray | float) -> np.ndarray:
        return np.asarray(np.interp(t, times, 0.01 * (1 + 0.5 * np.sin(40 * times))))

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        v = slip(t)
        g = values["F_C"] + (values["F_S"] - values["F_C"]) * np.exp(-((v / values["v_s"]) ** 2))
        return np.asarray(v - values["sigma0"] * np.abs(v) / g * z)

    z = np.zeros(1)
    deflections = [0.0]
    for begin, end in pairwise(times):  # the slip has a kink at every sample
        z = solve_ivp(rate, (begin, end), z, "LSODA", rtol=1e-12, atol=1e-18).y[:, -1]
        deflections.append(float(z[0]))
    zs = np.array(deflections)
    rates = np.array([rate(t, value) for t, value in zip(times, zs, strict=True)])
    return np.asarray(values["sigma0"] * zs + values["sigma1"] * rates + values["sigma2"] * slip(times))


def test_sensitivities_are_those_of_a_precise_solution() -> None:
    """Richardson differences of Radau at 1e-11 on the law written down again."""
    times = np.linspace(0, 0.02, 21)
    run = Run(times, {"slip_velocity": 0.01 * (1 + 0.5 * np.sin(40 * times))}, ("friction_force",))
    names = ("sigma0", "sigma1", "sigma2", "F_C", "F_S", "v_s")
    slopes = sensitivities(run, SMOOTH, names)["friction_force"]
    numbers = {name: float(SMOOTH[name]) for name in names}

    def central(name: str, share: float) -> np.ndarray:
        step = share * numbers[name]
        up, down = (friction({**numbers, name: numbers[name] + side * step}, times) for side in (1, -1))
        return np.asarray((up - down) / (2 * step))

    for name in names:
        precise = (4 * central(name, 5e-4) - central(name, 1e-3)) / 3
        assert np.abs(slopes[name] - precise).max() < 2e-4 * np.abs(precise).max(), name


def test_a_sensitivity_at_a_bound_looks_from_within() -> None:
    """An effect at its neutral end: the force grows by width for each N/m of the edge force."""
    run = Run(np.array([0.0, 1e-6]), {}, ("principal_force",))
    values: dict[str, float | str] = {"kinematics": "external", "slip_velocity": 0.1, "uncut_thickness": 1e-4, "edge_force.K_ep": 0.0}
    slopes = sensitivities(run, values, ["edge_force.K_ep", "width"], ("edge_force",))["principal_force"]
    assert slopes["edge_force.K_ep"] == pytest.approx(np.full(2, 1e-3), rel=1e-6)


def test_choices_have_no_sensitivity() -> None:
    with pytest.raises(ParameterError, match="no number"):
        sensitivities(RIG, {}, ["friction_law"])


def test_batch_of_one() -> None:
    batch: Batch = run_many(RIG, {"kinematics": "external"})
    assert batch.count == 1
    assert batch.rows["friction_force"].shape == (1, TIMES.size)
