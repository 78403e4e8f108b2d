"""Does every axis of a figure say what it shows, in the unit in which the tables show it?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from evat.model import Trace
from evat.plots import cycles as plot
from matplotlib.figure import Figure


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that were drawn, as they are saved."""
    saved: list[Figure] = []
    save = plot.save_figure

    def kept(figure: Figure, path: Path) -> Path:
        saved.append(figure)
        return save(figure, path)

    monkeypatch.setattr(plot, "save_figure", kept)
    return saved


def trace(**columns: float) -> Trace:
    times = np.linspace(0, 1e-4, 5)
    return Trace(times, {name: np.full(5, value) for name, value in columns.items()}, dict.fromkeys(columns, ""), {})


@pytest.mark.parametrize(
    ("name", "value", "shown", "unit"),
    [
        ("slip_velocity_used", 0.5, 30.0, "[m/min]"),
        ("theta_used", 1.0, 60.0, "[m/min]"),
        ("uncut_thickness_used", 1e-4, 100.0, "[um]"),
        ("shear_angle", np.pi / 4, 45.0, "[deg]"),
        ("contact_temperature", 300.0, 26.85, "[degC]"),
        ("friction_force", 2.0, 2.0, "[N]"),
        ("mean_contact_ratio", 0.4, 0.4, "[-]"),
    ],
)
def test_a_column_is_shown_in_the_display_unit(
    name: str, value: float, shown: float, unit: str, figures: list[Figure], tmp_path: Path
) -> None:
    plot.plot_trace(trace(**{name: value}), tmp_path / "a.png", (name,))
    (axis,) = figures[0].axes
    assert axis.lines[0].get_ydata() == pytest.approx(shown, rel=1e-12)  # rounding of one product and one sum
    assert axis.get_ylabel().replace("\n", " ").split() == [*name.split("_"), unit]
    assert axis.get_xlabel() == "time [us]"


def test_every_axis_of_a_followed_record_has_a_unit(figures: list[Figure], tmp_path: Path) -> None:
    times = np.linspace(0, 30, 301)
    velocity = np.full(301, 1e-3)
    plot.plot_record(times, velocity, np.ones(301), np.full(301, 1.5), tmp_path / "a.png", "a record")
    slip, force, loop, residual = figures[0].axes
    units = [(axis.get_xlabel().split()[-1], axis.get_ylabel().split()[-1]) for axis in (slip, force, loop, residual)]
    assert units == [("[s]", "[m/min]"), ("[s]", "[N]"), ("[um]", "[N]"), ("[s]", "[N]")]
    assert slip.lines[0].get_ydata() == pytest.approx(0.06, rel=1e-12)
    assert np.diff(loop.lines[0].get_xdata()) == pytest.approx(100.0, rel=1e-9)  # 1 mm/s for 0.1 s
    assert residual.lines[0].get_ydata() == pytest.approx(0.5, rel=1e-12)
