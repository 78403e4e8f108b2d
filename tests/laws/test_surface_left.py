"""Is the chip bounded by all that earlier passes have left, however the ellipse lies and whichever way it is run through?"""

from __future__ import annotations

import re
from math import pi

import numpy as np
import pytest
from brute_force_surface import Ellipse, draw
from driving import AMPLITUDE, OMEGA, PERIOD, Values, at_angle, at_speed_ratio, events, started

KINDS = [(retrograde, raked) for retrograde in (False, True) for raked in (False, True)]


def values(ellipse: Ellipse) -> dict[str, float | str]:
    own = {"amplitude_y": ellipse.aspect * AMPLITUDE, "phase_y": pi + ellipse.lead, "rake_angle": ellipse.rake}
    return at_speed_ratio(ellipse.r, feed=ellipse.feed * AMPLITUDE, relative_tolerance=1e-6, **own)


def entries_and_exits(ellipse: Ellipse, start: float) -> np.ndarray:
    contact = started(values(ellipse), time=start / OMEGA)
    return np.array([OMEGA * t for t, before, after in events(contact, PERIOD, "in_contact") if before[0] != after[0]])


def compare(ellipse: Ellipse) -> None:
    """Thickness to 1e-6 of the feed, entry and exit to 1e-6 of a period."""
    angles = np.linspace(0, 2 * pi, 21)[:-1] + 0.013
    thickness = np.array([at_angle(psi, values(ellipse), "uncut_thickness_used")[0] for psi in angles]) / AMPLITUDE
    assert thickness == pytest.approx(ellipse.thickness(angles), abs=1e-6 * ellipse.feed)
    assert entries_and_exits(ellipse, 0.1) == pytest.approx(np.array(ellipse.turns(0.1, 600)), abs=1e-6 * 2 * pi)


@pytest.mark.parametrize(("retrograde", "raked"), KINDS)
@pytest.mark.parametrize("number", range(4))
def test_thickness_entry_and_exit_are_those_of_brute_force(number: int, retrograde: bool, raked: bool) -> None:
    compare(draw(number, retrograde=retrograde, raked=raked))


@pytest.mark.campaign
@pytest.mark.parametrize(("retrograde", "raked"), KINDS)
def test_two_hundred_ellipses_are_those_of_brute_force(retrograde: bool, raked: bool) -> None:
    for number in range(50):
        compare(draw(number, retrograde=retrograde, raked=raked))


NAMED = {
    "the backward stroke undercuts the forward one": Ellipse(0.33, aspect=1.27, lead=1.163, feed=3.59),
    "tilt of 34 degrees at HSR 0.9": Ellipse(0.9, lead=0.593, feed=10.0),
    "negative rake, tilted": Ellipse(
        0.4201821154418888, aspect=1.5318315233304036, lead=0.7623329527755183, rake=-0.07146799569285378, feed=8.526972241237887
    ),
    "short contact where the wall before meets the nominal surface": Ellipse(
        0.5691112664597854, aspect=0.3752716083199132, lead=2.391865087989751, feed=0.2419884131037677
    ),
    "small advance, run through backward": Ellipse(0.02, lead=pi - 0.4, feed=3.0),
}


@pytest.mark.parametrize("name", NAMED)
def test_ellipses_that_each_had_an_error(name: str) -> None:
    assert NAMED[name].turns(0.1)
    compare(NAMED[name])


def test_run_through_backward_the_tool_enters_where_the_loop_before_ends() -> None:
    """Upright, without rake: the stroke back took all up to its right end, so what is cut begins there, at full thickness, and lasts until
    the tool turns; r (psi + 2 pi) + sin(psi) = r q + sin(q) with q = acos(-r)."""
    r, feed = 0.3, 6.0
    q = np.arccos(-r)
    low, high = -q, q
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if r * (middle + 2 * pi) + np.sin(middle) < r * q + np.sin(q) else (low, middle)
    ellipse = Ellipse(r, lead=pi, feed=feed)
    assert entries_and_exits(ellipse, q - 4) == pytest.approx([low, q], abs=1e-9)
    thickness = at_angle(0.5 * (low + q), values(ellipse), "uncut_thickness_used")[0] / AMPLITUDE
    assert thickness == pytest.approx(feed - 1 - np.cos(0.5 * (low + q)), rel=1e-12)


def test_with_a_rake_the_cut_goes_on_while_the_tool_turns_back() -> None:
    """u_x cos(alpha) + u_y sin(alpha) ends the cut, past the angle acos(-r) at which u_x does."""
    ellipse = Ellipse(0.3, rake=0.3, feed=10.0)
    ends = entries_and_exits(ellipse, 0.1)[0]
    assert ends > np.arccos(-0.3) + 0.2
    assert ellipse.approach(np.array([ends]))[0] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize(
    ("ellipse", "warned"),
    [
        (Ellipse(0.3, feed=10.0), ""),
        (Ellipse(0.3, lead=0.6, feed=10.0), ""),
        (Ellipse(0.3, lead=1.2, feed=10.0), "clearance face"),  # where it turns forward it is below what it cut before
        (Ellipse(0.3, lead=1.35, feed=10.0), "clearance face"),
        (Ellipse(0.3, lead=pi, feed=10.0), "clearance face"),
        (Ellipse(0.9, aspect=3.0, lead=-1.4, rake=0.5, feed=10.0), "throughout the cycle"),
    ],
)
def test_what_no_force_is_modelled_of_is_said(ellipse: Ellipse, warned: str) -> None:
    contact = started(values(ellipse))
    contact.advance(PERIOD)
    said = " ".join(contact.warnings())
    assert warned in said
    assert warned or "clearance" not in said


def test_a_backward_stroke_in_the_air_is_no_interference() -> None:
    """The nominal surface below the whole backward stroke: lead = 1.4 at r = 0.3 undercuts at its right turn, but above a thin cut."""
    contact = started(values(Ellipse(0.3, lead=1.4, feed=0.05)))
    contact.advance(PERIOD)
    assert not any("clearance face" in line for line in contact.warnings())


# ---- cusps ----


def cusp_height(ellipse: Ellipse, **own: float) -> float:
    """In amplitudes."""
    contact = started({**values(ellipse), **own})
    contact.evaluate()
    return float(contact.get("cusp_height")) / AMPLITUDE


@pytest.mark.parametrize(("r", "height"), [(0.05, 0.01125), (0.1, 0.04154), (0.2, 0.14532), (0.3, 0.29272), (0.5, 0.68098)])
def test_cusps_of_an_upright_ellipse_stand_where_one_stroke_meets_the_next(r: float, height: float) -> None:
    """To the digits of a table that was worked out apart; whatever the amplitude across, up to the nominal surface; the same where the
    search that all other ellipses need finds them."""
    for aspect in (0.4, 2.0):
        assert cusp_height(Ellipse(r, aspect=aspect, feed=9.0)) == pytest.approx(aspect * height, abs=6e-6 * aspect)
    assert cusp_height(Ellipse(r, lead=1e-7, feed=9.0)) == pytest.approx(cusp_height(Ellipse(r, feed=9.0)), rel=1e-6)
    assert cusp_height(Ellipse(r, feed=0.5 * height)) == pytest.approx(0.5 * height, rel=1e-12)


def test_cusps_are_those_of_brute_force() -> None:
    """The highest place that all passes leave, of 2000 in one advance, between two of which a wall may rise by a thousandth."""
    for number in range(4):
        ellipse = draw(number, retrograde=number % 2 == 1, raked=False)
        places = np.linspace(0, 2 * pi * ellipse.r, 2001)
        late = 2 * pi * np.ceil(2 + (4 + places[-1]) / (2 * pi * ellipse.r))
        brute = float(ellipse.left(places, np.full(places.size, late)).max()) + ellipse.aspect
        assert cusp_height(ellipse) == pytest.approx(brute, abs=1e-3 * ellipse.aspect)


def test_without_separation_the_surface_is_the_path_itself() -> None:
    assert cusp_height(Ellipse(1.2, aspect=0.7, feed=9.0)) == pytest.approx(2 * 0.7, rel=1e-12)
    assert cusp_height(Ellipse(0.3, aspect=0.7, feed=9.0), amplitude_x=0.0) == pytest.approx(2 * 0.7, rel=1e-12)
    assert cusp_height(Ellipse(0.3, lead=0.5, feed=9.0), cutting_speed=0.0) == 0
    given = started({"kinematics": "external", "slip_velocity": 0.1, "normal_load": 1.0, "cutting_speed": 0.1})
    assert given.get("cusp_height") == 0


def test_cusps_follow_the_cutting_speed() -> None:
    """Looked at anew where the ellipse is another one, and at the tool's own amplitude where an effect leaves less of it."""
    times = np.linspace(0, PERIOD, 6)
    speeds = np.linspace(0.1, 0.5, 6) * OMEGA * AMPLITUDE
    contact = started({**values(Ellipse(0.1, lead=0.4, feed=9.0)), "cutting_speed": float(speeds[0])})
    heights = contact.run(times, {"cutting_speed": speeds}, ("cusp_height",))[:, 0] / AMPLITUDE
    assert heights == pytest.approx([cusp_height(Ellipse(v / OMEGA / AMPLITUDE, lead=0.4, feed=9.0)) for v in speeds], rel=1e-12)
    assert np.all(np.diff(heights) > 0.01)


def test_cusps_end_at_the_nominal_surface_wherever_that_or_the_tool_stands() -> None:
    """A tool that is led away from the work, or a surface that the run-out lowers, is a smaller feed."""
    ellipse, away = Ellipse(0.5, feed=0.5), 0.3 * AMPLITUDE
    low = cusp_height(Ellipse(0.5, feed=0.2))
    assert low == pytest.approx(0.2, rel=1e-12)
    led = started({**values(ellipse), "kinematics": "combined", "tool_displacement_y": away})
    turned = {"run_out.amplitude": away, "run_out.phase": -pi / 2, "run_out.spindle_frequency": 1e-3}
    lowered = started({**values(ellipse), **turned}, ("run_out",))
    for contact in (led, lowered):
        contact.evaluate()
        assert contact.get("cusp_height") / AMPLITUDE == pytest.approx(low, rel=1e-9)


# ---- the clearance face ----

CLEARANCE = 0.12  # rad


def told_depth(given: Values, on: tuple[str, ...] = ()) -> float:
    """Of the clearance face in the surface [m], as the warning says; 0 where there is none."""
    told = [line for line in started(given, on).warnings() if "clearance_angle" in line]
    return 1e-6 * float(re.search(r"by up to ([0-9]+\.[0-9]{3}) um", told[0])[1]) if told else 0.0


def depth_of_flank(ellipse: Ellipse, on: tuple[str, ...] = (), **own: float) -> float:
    """In amplitudes, of 100 um, so that the nanometres of the warning are 1e-5."""
    given = values(ellipse)
    larger = {name: 1e-4 / AMPLITUDE * float(given[name]) for name in ("amplitude_y", "feed", "cutting_speed")}
    return 1e4 * told_depth({**given, **larger, "amplitude_x": 1e-4, "clearance_angle": CLEARANCE, **own}, on)


@pytest.mark.parametrize(("retrograde", "raked"), KINDS)
def test_the_clearance_face_is_as_deep_in_the_surface_as_by_brute_force(retrograde: bool, raked: bool) -> None:
    for ellipse in (
        draw(0, retrograde=retrograde, raked=raked),
        *([NAMED["the backward stroke undercuts the forward one"]] if raked else []),
    ):
        assert depth_of_flank(ellipse) == pytest.approx(ellipse.flank_depth(CLEARANCE), abs=2e-5)


@pytest.mark.campaign
@pytest.mark.parametrize(("retrograde", "raked"), KINDS)
def test_two_hundred_clearance_faces_are_as_deep_as_by_brute_force(retrograde: bool, raked: bool) -> None:
    """Brute force may miss the deepest place by some thousandths, where it is a sharp one."""
    for number in range(50):
        ellipse = draw(number, retrograde=retrograde, raked=raked)
        brute = ellipse.flank_depth(CLEARANCE)
        assert brute - 2e-5 < depth_of_flank(ellipse) < brute + 5e-3


@pytest.mark.parametrize("feed", [100.0, 1.2])
def test_a_clearance_face_without_separation_stands_in_the_wave_of_its_own_path(feed: float) -> None:
    """At a speed ratio of 3 the tool passes each place once: the highest of the sheared surface so far, over the tip."""
    psi = np.linspace(-2 * pi, 2 * pi, 400001)
    x, y = 3 * psi + np.sin(psi + 0.4), -2 * np.cos(psi)
    deep = np.maximum.accumulate(np.minimum(y, feed - 2) + np.tan(CLEARANCE) * x) - (y + np.tan(CLEARANCE) * x)
    given = {**at_speed_ratio(3), "amplitude_x": 1e-4, "amplitude_y": 2e-4, "phase_x": 0.4 - pi / 2}
    given |= {"cutting_speed": 3 * 1e-4 * OMEGA, "feed": 1e-4 * feed, "clearance_angle": CLEARANCE}
    assert 1e4 * told_depth(given) == pytest.approx(deep.max(), abs=2e-5)


def test_a_clearance_face_is_told_of_only_where_its_angle_is_stated_and_it_is_not_free() -> None:
    upright = Ellipse(0.05, feed=10.0)  # at its entry it goes down by 0.1429 rad
    assert depth_of_flank(upright, clearance_angle=0.0) == depth_of_flank(upright, clearance_angle=0.15) == 0
    assert 0 < depth_of_flank(upright, clearance_angle=0.12) < depth_of_flank(upright, clearance_angle=0.1)
    assert told_depth({"kinematics": "external", "clearance_angle": 0.1}) == 0


def test_the_clearance_face_is_that_of_the_ellipse_that_is_run_through() -> None:
    turned = depth_of_flank(Ellipse(0.3, feed=10.0), ("ellipse_phase_error",), **{"ellipse_phase_error.delta": 0.4})
    assert turned == depth_of_flank(Ellipse(0.3, lead=0.4, feed=10.0)) != depth_of_flank(Ellipse(0.3, feed=10.0))
