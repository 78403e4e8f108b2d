"""Is an effect refused where the input is absent without which it says nothing, and only there?"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from evat.model import ParameterError
from evat.models.simulate import simulate
from evat.native import kernel
from evat.native.kernel import ContactTables
from evat.required_inputs import check_required_inputs, missing_inputs

MODEL = ContactTables()
THERMAL = tuple(effect.name for effect in kernel.effects() if "proxy_speed" in effect.needs)
LOADED = tuple(effect.name for effect in kernel.effects() if "normal_load" in effect.needs)


def test_there_is_something_to_ask() -> None:
    assert len(THERMAL) >= 5
    assert LOADED


def test_the_inputs_of_each_kinematics_are_those_whose_meaning_says_so() -> None:
    """But for cutting_speed, which every kinematics reads: the ellipse has a start value for it."""
    kinematics = kernel.variable("kinematics").choices
    for known in kernel.variables():
        said = tuple(k for k in kinematics if known.causality == "input" and f"where kinematics = {k}" in known.meaning)
        assert known.required_with == (("external",) if known.name == "cutting_speed" else said), known.name


@pytest.mark.parametrize("effect", THERMAL)
@pytest.mark.parametrize(
    ("values", "columns", "missing"),
    [
        ({}, (), []),  # the ellipse has a slip speed
        ({"proxy_source": "cutting_speed"}, (), []),
        ({"kinematics": "combined", "proxy_source": "cutting_speed"}, (), []),
        ({"proxy_source": "proxy_speed"}, (), ["proxy_speed"]),
        ({"proxy_source": 1.0}, (), ["proxy_speed"]),  # a choice by its place
        ({"proxy_source": "proxy_speed", "proxy_speed": 0.0}, (), []),
        ({"proxy_source": "proxy_speed"}, ("proxy_speed",), []),
        ({"proxy_source": "proxy_speed"}, ("contact_temperature",), ["proxy_speed"]),
        ({"proxy_source": "contact_temperature", "proxy_speed": 1.0}, (), ["contact_temperature"]),
        ({"proxy_source": "contact_temperature"}, ("contact_temperature",), []),
        ({"kinematics": "external"}, (), ["slip_velocity"]),
        ({"kinematics": "external"}, ("slip_velocity",), []),
        ({"kinematics": "external", "proxy_source": "cutting_speed"}, ("slip_velocity",), ["cutting_speed"]),
        ({"kinematics": "external", "proxy_source": "cutting_speed", "cutting_speed": 1.0}, ("slip_velocity",), []),
    ],
)
def test_the_proxy_needs_what_it_is_taken_from(
    effect: str, values: Mapping[str, float | str], columns: tuple[str, ...], missing: list[str]
) -> None:
    assert list(missing_inputs(MODEL, [effect], values, columns)) == missing
    assert list(missing_inputs(MODEL, [], values, columns)) == []
    assert list(missing_inputs(MODEL, [], {**values, effect: 1.0}, columns)) == missing  # switched on as a value


@pytest.mark.parametrize("effect", LOADED)
def test_a_load_is_needed_only_where_the_chip_does_not_give_it(effect: str) -> None:
    for kinematics in kernel.variable("kinematics").choices:
        wanted = {"normal_load": [effect]} if kinematics == "external" else {}
        assert missing_inputs(MODEL, [effect], {"kinematics": kinematics}) == wanted
        assert missing_inputs(MODEL, [effect], {"kinematics": kinematics}, ["normal_load"]) == {}


def test_the_error_says_what_was_asked_what_is_missing_and_what_to_do() -> None:
    two = THERMAL[:2]
    with pytest.raises(ParameterError) as caught:
        check_required_inputs(MODEL, two, {"proxy_source": "contact_temperature"})
    text = str(caught.value)
    for part in (*two, "contact_temperature", kernel.variable("contact_temperature").meaning, "in K", "column", "proxy_source", "switch"):
        assert part in text


def test_other_effects_need_nothing() -> None:
    others = [effect.name for effect in kernel.effects() if not effect.needs]
    for kinematics in kernel.variable("kinematics").choices:
        check_required_inputs(MODEL, others, {"kinematics": kinematics, "proxy_source": "contact_temperature"})


def test_a_joint_has_no_work_that_turns_and_no_chip() -> None:
    """By what each says of itself: what the tool's path or the chip is in has no place where slip alone is given."""
    joint = {effect.name for effect in kernel.effects() if effect.applies("external", ["slip_velocity", "normal_load"])}
    cut = {effect.name for effect in kernel.effects() if effect.applies("external", ["slip_velocity", "uncut_thickness"])}
    ellipse = {effect.name for effect in kernel.effects() if effect.applies("internal")}
    of_the_chip = {effect.name for effect in kernel.effects() if effect.stage in ("shear", "load")} | {
        "run_out",
        "regenerative",
        "sticking_limit",
        "kienzle_force",
    }
    assert not joint & of_the_chip
    assert cut - joint == of_the_chip - {"process_damping"}, (  # which is of the tool's own motion
        'an effect of the shear or the load says .applies_to = "internal, combined, uncut_thickness": '
        f"{', '.join(sorted((cut - joint) ^ (of_the_chip - {'process_damping'})))}"
    )
    assert of_the_chip | {"amplitude_loss", "ellipse_phase_error"} <= ellipse
    assert {"stribeck", "sensor_gain", "dwell_strengthening"} <= joint & cut & ellipse


@pytest.mark.parametrize("effect", THERMAL)
def test_a_run_is_refused_before_it_begins(effect: str) -> None:
    values: dict[str, float | str] = {"proxy_source": "proxy_speed", "kinematics": "external", "slip_velocity": 0.1}
    with pytest.raises(ParameterError, match=f"{effect} needs the input proxy_speed"):
        simulate(values, [effect])
    simulate({**values, "proxy_speed": 0.1}, [effect])
    times = np.linspace(0, 1e-3, 5)
    simulate(values, [effect], times=times, inputs={"proxy_speed": np.full(5, 0.1)})
