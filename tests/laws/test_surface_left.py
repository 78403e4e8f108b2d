"""Is the chip bounded by all that earlier passes have left, however the ellipse lies and whichever way it is run through?"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from brute_force_surface import Ellipse, draw
from driving import AMPLITUDE, OMEGA, PERIOD, at_angle, at_speed_ratio, events, started

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
