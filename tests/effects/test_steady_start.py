"""Does a run begin where a motion like that of its start leads? Then what lags has nothing to catch up with, and a lag of 0 is none."""

from __future__ import annotations

from collections.abc import Mapping

import evat
import numpy as np
import pytest
from evat.model import Run
from evat.models.contact import ContactModel

OUTPUTS = ("measured_friction_force", "friction_force", "theta_used", "slip_velocity_used")
LAGS: dict[str, dict[str, float]] = {
    "sensor_lowpass": {"sensor_lowpass.time_constant": 0.02},
    "dynamometer_resonance": {"dynamometer_resonance.natural_period": 0.03, "dynamometer_resonance.damping_ratio": 0.1},
    "proxy_lag": {"proxy_lag.time_constant": 0.5},
    "rate_and_state": {"rate_and_state.b": 0.05, "rate_and_state.d_c": 3e-4},
    "backlash": {"backlash.gap": 2e-4},
}


def followed(effect: str, start: str, values: Mapping[str, float] | None = None, slip: float = -0.03) -> dict[str, np.ndarray]:
    """200 ms of a slip and a proxy that do not change, with bristles that are bent as that slip bends them."""
    times = np.linspace(0.0, 0.2, 101)
    inputs = {"slip_velocity": np.full(times.size, slip), "proxy_speed": np.full(times.size, 0.2)}
    held = {"kinematics": "external", "proxy_source": "proxy_speed", "initial_state": start, "thermal_softening.k_Q": 3e5}
    model, on = ContactModel(threads=1), ("thermal_softening", effect)
    settled = model.settled(("bristle_deflection",), on, {**held, **(values or LAGS[effect]), "slip_velocity": slip, "proxy_speed": 0.2})
    bent = {"bristle_deflection": float(settled["bristle_deflection"][0])}
    rows = model.simulate_many(Run(times, inputs, OUTPUTS), on, {**held, **(values or LAGS[effect]), **bent})
    return {name: row[0] for name, row in rows.items()}


def unsteady(rows: Mapping[str, np.ndarray]) -> float:
    """The largest change in the run, in the largest value of its output."""
    return max(float(np.ptp(row)) / float(np.abs(row).max()) for row in rows.values())


@pytest.mark.parametrize("effect", LAGS)
def test_what_does_not_change_is_steady_from_the_start(effect: str) -> None:
    assert unsteady(followed(effect, "steady")) < 1e-6
    assert unsteady(followed(effect, "at_rest")) > 1e-3


@pytest.mark.parametrize(
    ("effect", "nearly_none"),
    [("sensor_lowpass", "time_constant"), ("dynamometer_resonance", "natural_period"), ("proxy_lag", "time_constant"), ("backlash", "gap")],
)
def test_a_lag_of_nearly_nothing_is_none_at_any_time(effect: str, nearly_none: str) -> None:
    """Begun at 0, a filter of a nanosecond shows nothing at the first sample: to a fit that looks for its time constant, a wall."""
    tiny, none = (followed(effect, "steady", {**LAGS[effect], f"{effect}.{nearly_none}": value}) for value in (1e-9, 0.0))
    assert tiny["measured_friction_force"] == pytest.approx(none["measured_friction_force"], rel=1e-6)


def test_what_stands_has_not_moved() -> None:
    """At rest nobody knows from which side a slack was last taken up, and nothing renews what the contact remembers."""
    for effect in ("backlash", "rate_and_state"):
        still, before = (followed(effect, start, slip=0.0) for start in ("steady", "at_rest"))
        assert all(np.array_equal(still[name], before[name]) for name in OUTPUTS)


@pytest.mark.parametrize("period", [2.5e-5, 5e-5, 2.5e-4, 1e-3, 3e-3])
@pytest.mark.parametrize("damping", [0.0, 1e-15])
def test_a_dynamometer_without_damping_rests_under_the_force_of_the_start(period: float, damping: float) -> None:
    """After whole periods it is where it was, wherever that is: a start that is sought by what a time leaves as it is began at 0 N."""
    own = {"dynamometer_resonance.natural_period": period, "dynamometer_resonance.damping_ratio": damping}
    given = {"kinematics": "external", "uncut_thickness": 1e-4, "slip_velocity": 0.01, "initial_state": "steady"}
    cut = {"averaging": "cycle", "initial_state": "periodic"}
    for values in (given, cut):
        contact = evat.Contact({**values, **own}, on=["dynamometer_resonance"])
        contact.start()
        for name in ("friction_force", "principal_force", "feed_force"):
            force, measured = contact.get(name), contact.get(f"measured_{name}")
            assert measured == pytest.approx(force, rel=1e-12), (values, name)
            assert contact.get(f"dynamometer_resonance.{name}_speed") == pytest.approx(0, abs=1e-6 * abs(force) / period)


@pytest.mark.parametrize(("effect", "state"), [("proxy_lag", "proxy_lag.theta"), ("rate_and_state", "rate_and_state.memory")])
def test_a_slack_that_is_taken_up_lets_the_others_settle_at_the_whole_slip(effect: str, state: str) -> None:
    """They had settled at the millionth of it that a slack lets through before it is crossed."""
    values = {"kinematics": "external", "uncut_thickness": 1e-4, "slip_velocity": -0.03, "initial_state": "steady", **LAGS[effect]}
    alone, beside = (evat.Contact(values, on=on) for on in ([effect], [effect, "backlash"]))
    alone.start()
    beside.start()
    assert beside.get(state) == pytest.approx(alone.get(state), rel=1e-12)
    assert beside.get("backlash.place") == -1


@pytest.mark.parametrize("sensors", [["sensor_delay"], ["sensor_delay", "sensor_lowpass"]])
@pytest.mark.parametrize(("effect", "start"), [("rate_and_state", "steady"), ("maxwell_slip", "steady"), ("maxwell_slip", "at_rest")])
def test_what_a_sensor_recalls_of_the_time_before_is_the_force_of_the_start(effect: str, start: str, sensors: list[str]) -> None:
    """It had recalled that of states which had not settled yet, or of elements that nothing had bent, and its filter settled at that."""
    values = {"kinematics": "external", "slip_velocity": 0.03, "initial_state": start, "sensor_delay.time": 5e-3}
    own = {
        "rate_and_state": {"friction_law": "coulomb", **LAGS["rate_and_state"]},
        "maxwell_slip": {"sigma2": 0.0, "F_S": 9.0, "bristle_deflection": 9e-6},
    }
    filtered = {"sensor_lowpass.time_constant": 0.0 if start == "at_rest" else 1e-3}
    contact = evat.Contact({**values, **own[effect], **filtered}, on=[effect, *sensors])
    contact.start()
    begun = contact.get("friction_force")
    for _ in range(10):
        assert contact.get("measured_friction_force") == pytest.approx(begun, rel=1e-9)
        contact.advance(4e-4)
