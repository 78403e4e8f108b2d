"""Do results fit a notebook? Mappings, xarray and pandas with units, pictures that say what they leave out, tables in HTML."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import evat
import numpy as np
import pytest
from evat.model import Trace, nearest
from evat.notebook.choice import MOST_SHOWN, chosen, left_out
from evat.notebook.panels import envelope, over_time, prefixed
from evat.systems.sweep import Row, Sweep, SweepAxis

TIMES = np.linspace(0, 1, 4001)


@pytest.fixture
def trace() -> Trace:
    return evat.simulate({"friction_law": "coulomb"}, cycles=1, samples_per_cycle=50)


def test_a_trace_is_a_mapping(trace: Trace) -> None:
    assert list(trace) == list(trace.columns)
    assert len(trace) == len(trace.columns)
    assert "friction_force" in trace
    assert "friction" not in trace
    assert trace.get("friction") is None
    assert np.array_equal(dict(trace)["friction_force"], trace["friction_force"])
    with pytest.raises(evat.ParameterError, match="did you mean friction_force"):
        trace["friction"]


def test_a_trace_becomes_a_dataset_and_a_frame_with_units(trace: Trace) -> None:
    data, frame = trace.to_xarray(), trace.to_pandas()
    assert data["friction_force"].attrs["units"] == "N" == frame.attrs["units"]["friction_force"]
    assert data["time"].attrs["units"] == "s"
    assert np.array_equal(data["friction_force"].values, trace["friction_force"])
    assert np.array_equal(frame["friction_force"], trace["friction_force"])
    assert np.array_equal(frame.index, trace.times)
    assert all(isinstance(value, (str, int, float)) for value in data.attrs.values())  # what every file format takes


def test_a_result_is_printed_in_a_dozen_lines(trace: Trace) -> None:
    """It was pages of arrays: 10 thousand characters of 50 samples. The rest is counted and named."""
    many = replace(
        trace, columns={f"part{n // 9}.signal{n}": np.full(TIMES.size, float(n)) + TIMES for n in range(60)}, times=TIMES, units={}
    )
    first, head, *lines, rest = repr(many).splitlines()
    assert (first, head.split()) == ("Trace: 60 columns, 4001 samples, 0 to 1 s", ["name", "unit", "least", "mean", "largest", "last"])
    assert len(lines) == MOST_SHOWN
    assert lines[0].split() == ["part0.signal0", "0", "0.5", "1", "1"]
    assert {line.split(".")[0].strip() for line in lines} == {f"part{n}" for n in range(7)}  # some of each component
    assert rest.strip().startswith("48 of 60 are not shown: part0.signal2, ")
    run = evat.Run(TIMES, {"slip_velocity": np.full(TIMES.size, 0.1)}, ("friction_force",))
    batch = evat.run_many(run, {"kinematics": "external", "friction_law": "coulomb", "F_C": np.linspace(1, 9, 50)})
    assert repr(batch).splitlines()[0] == "Batch: 50 sets, rows over time"
    assert repr(swept("a.b", "m")).splitlines()[-1].strip() == "1 of 4 runs failed; the first: broken"
    made = evat.orthogonal({"friction_law": "coulomb"}, motion="reversal", repeats=2, speeds=[0.5], rate=20.0)
    assert repr(made).endswith("2 trials of 1 conditions; measured: friction_force>")
    assert max(len(repr(each)) for each in (batch, swept("a.b", "m"), made, made.trials[0])) < 400


def test_sets_become_coordinates() -> None:
    run = evat.Run(TIMES[:5], {"slip_velocity": np.full(5, 0.1)}, ("friction_force",))
    levels = np.array([5.0, 10.0, 20.0])
    values = {"kinematics": "external", "friction_law": "coulomb", "F_C": levels}
    batch = evat.run_many(run, values)
    data = batch.to_xarray()
    assert data["friction_force"].dims == ("set", "time")
    assert np.array_equal(data["F_C"].values, levels)
    assert data["F_C"].attrs["units"] == "N"
    assert batch.to_pandas().shape == (15, 2)
    assert np.array_equal(batch["friction_force"], batch.rows["friction_force"])
    sums = evat.run_many(run, values, give="sums")
    assert np.array_equal(sums.to_xarray()["friction_force"].values, sums.sums["friction_force"])
    (axis,) = sums.plot().axes
    assert axis.get_xlabel() == "F C [N]"
    assert np.array_equal(axis.lines[0].get_xdata(), levels)
    with pytest.raises(evat.ParameterError, match="did not differ"):
        sums.plot(over="sigma0")


def swept(label: str, unit: str) -> Sweep:
    axes = (SweepAxis(label, unit, ("3e-06", "6e-06"), ({}, {})), SweepAxis("law", "1", ("a", "b"), ({}, {})))
    means = {(i, j): {"contact.force": 10.0 * i + j, "contact.speed_ratio": 0.5 - 0.1 * i} for i in range(2) for j in range(2)}
    rows = tuple(Row(place, {} if place == (1, 1) else mean, "broken" if place == (1, 1) else "") for place, mean in means.items())
    return Sweep(axes, rows, {"contact.force": "N", "contact.speed_ratio": "1"}, system="mine")


def test_a_sweep_is_a_grid() -> None:
    data = swept("contact.amplitude_x", "m").to_xarray()
    assert dict(data.sizes) == {"contact.amplitude_x": 2, "law": 2}
    assert np.array_equal(data["contact.force"].values, [[0, 1], [10, np.nan]], equal_nan=True)
    assert data["contact.amplitude_x"].attrs["units"] == "m"
    assert "1 of 4 runs failed; the first: broken" in swept("a.b", "m")._repr_html_()
    whole = swept("a.b", "m")
    shown = replace(whole, rows=tuple(replace(row, failure="") for row in whole.rows))._repr_html_()
    assert "contact.force" in shown
    assert "failed" not in shown


def test_a_sweep_is_drawn_over_what_was_swept() -> None:
    """Over the amplitude, not over the speed ratio that it changes; over this where a speed was swept."""
    over_amplitude, over_speed = (
        swept("contact.amplitude_x", "m").plot("contact.force"),
        swept("spindle.speed", "rad/s").plot("contact.force"),
    )
    assert over_amplitude.axes[0].get_xlabel() == "contact: amplitude x [um]"
    assert over_amplitude.axes[0].lines[0].get_xdata() == pytest.approx([3, 6])
    assert over_speed.axes[0].get_xlabel().startswith("speed ratio")
    assert over_speed.axes[0].lines[0].get_xdata() == pytest.approx([0.4, 0.5])


def test_a_picture_of_many_signals_chooses_and_says_what_it_left_out() -> None:
    moving = {f"a.{n}": np.sin(n * TIMES + n) for n in range(20)}
    columns = {"a.still": np.ones_like(TIMES), **moving, "b.only": TIMES}
    names = chosen(columns)
    assert len(names) == MOST_SHOWN
    assert "b.only" in names  # each component has its turn
    assert "a.still" not in names
    said = left_out(columns, names)
    assert said.startswith("10 of 22 are not drawn: a.still, ")
    assert said.endswith(" and 4 more")
    figure = over_time(TIMES, columns, {})
    assert len(figure.axes) == MOST_SHOWN
    assert "10 of 22 are not drawn" in figure._supxlabel.get_text()
    assert not over_time(TIMES, {"a": TIMES}, {}).texts


def test_what_swings_too_fast_is_drawn_as_its_range() -> None:
    fast, slow = np.sin(2 * np.pi * 400.123 * TIMES) + TIMES, np.sin(2 * np.pi * 3 * TIMES)
    figure = over_time(TIMES, {"fast": fast, "slow": slow}, {})
    band, line = figure.axes
    assert len(band.collections) == 1
    assert not line.collections
    low, high = band.dataLim.y0, band.dataLim.y1
    assert (low, high) == pytest.approx((fast.min(), fast.max()), abs=0.02)  # a few samples a cycle miss the tip
    mean = band.lines[0]
    assert mean.get_ydata() == pytest.approx(mean.get_xdata() / 1e3, abs=0.25)  # the swing is gone (clock in ms); 2.x cycles leave a rest
    assert "least to largest within" in figure._supxlabel.get_text()


def test_an_envelope_loses_no_extreme() -> None:
    values = np.random.default_rng(0).normal(size=1001)
    middle, least, mean, largest = envelope(np.arange(1001.0), values, 10)
    assert middle.size == 10
    assert (least.min(), largest.max()) == (values.min(), values.max())
    assert np.all((least <= mean) & (mean <= largest))


@pytest.mark.parametrize(
    ("largest", "unit", "shown"),
    [(3e-6, "m", (3.0, "um")), (2.5e5, "N/m", (250.0, "kN/m")), (20.0, "N", (20.0, "N")), (1e-6, "1", (1e-6, "1")), (0.0, "m", (0.0, "m"))],
)
def test_numbers_are_read_with_a_prefix(largest: float, unit: str, shown: tuple[float, str]) -> None:
    factor, of = prefixed(np.array([-largest, 0.0]), unit)
    assert (factor * largest, of) == (pytest.approx(shown[0]), shown[1])


def test_what_a_notebook_shows_is_escaped() -> None:
    name = "<script>alert(1)</script>"
    told = Trace(TIMES[:2], {name: TIMES[:2]}, {name: "$x"}, {})
    assert "<script>" not in told._repr_html_()
    assert told.plot()._repr_png_().startswith(b"\x89PNG")  # a dollar is no formula


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("SIGMA0", "did you mean sigma0?"),
        ("simga0", "did you mean sigma0?"),
        ("k_Q", "did you mean thermal_softening.k_Q?"),
        ("zzz", "there are sigma0, F_C, thermal_softening.k_Q."),
    ],
)
def test_the_nearest_name_is_told(typed: str, said: str) -> None:
    assert nearest(typed, ["sigma0", "F_C", "thermal_softening.k_Q"]) == said


def test_a_sweep_from_python_takes_units(systems: dict[str, Path]) -> None:
    made = evat.sweep_system(systems["stick_slip"], {"path.speed": ["50 mm/s", 0.1]}, stop="20 ms", step="1 ms")
    assert np.array_equal(made.to_xarray()["path.speed"].values, [0.05, 0.1])
    alone = evat.run_system(systems["stick_slip"], {"path": {"speed": "100 mm/s"}}, stop=0.02, step=1e-3)
    late = alone["guideway.friction_force"][alone.times >= 0.01 - 1e-9]
    assert made["guideway.friction_force"][1] == pytest.approx(np.mean((late[1:] + late[:-1]) / 2), rel=1e-12)
