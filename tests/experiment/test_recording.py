"""Is what is advised to be recorded scaled by the contact, and does a simulated record of it tell what it is said to show?"""

from __future__ import annotations

import pytest
from evat.model import ParameterError
from evat.motions import AMPLITUDES
from evat.native import kernel
from evat.studies.recording import PER_BEND, SPEEDS, recordings

VALUES = {"F_C": 8.0, "F_S": 10.0, "sigma0": 1e5, "v_s": 0.01}
LENGTH = 1e-4  # m: F_S/sigma0


def test_strokes_go_by_the_bristles_and_speeds_by_the_stribeck_curve() -> None:
    steady, reversals, strokes, _ = recordings(VALUES)
    assert strokes.strokes == pytest.approx([share * LENGTH for share in AMPLITUDES])
    assert steady.speeds == pytest.approx([share * 0.01 for share in SPEEDS])
    assert min(steady.speeds) < VALUES["v_s"] < max(steady.speeds)
    assert reversals.rate * LENGTH / VALUES["v_s"] == pytest.approx(PER_BEND)


def test_a_contact_twice_as_stiff_asks_for_half_the_stroke_and_twice_the_rate() -> None:
    soft, stiff = recordings(VALUES), recordings({**VALUES, "sigma0": 2e5})
    assert stiff[2].strokes == pytest.approx([stroke / 2 for stroke in soft[2].strokes])
    assert stiff[1].rate == pytest.approx(2 * soft[1].rate)


def test_a_steady_speed_lasts_until_the_bristles_have_settled() -> None:
    slow = recordings({**VALUES, "v_s": 1e-5})[0]
    assert slow.seconds * min(slow.speeds) >= 50 * LENGTH


def test_what_is_said_to_show_is_a_parameter_or_an_effect() -> None:
    known = set(kernel.by_name()) | {effect.name for effect in kernel.effects()}
    for each in recordings({}):
        assert set(each.shows) <= known
        assert each.repeats >= 1


def test_a_contact_without_stiffness_is_refused() -> None:
    with pytest.raises(ParameterError, match="above 0"):
        recordings({**VALUES, "F_C": 0.0, "F_S": 0.0})
