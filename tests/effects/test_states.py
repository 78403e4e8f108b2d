"""Are the states of the effects solved, in co-simulation and in model exchange alike? Tolerance, and Radau on the same derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from asking import FASTEST, begun
from driving import PERIOD, Values, read
from evat.native import kernel
from exchange import exchange

CUT: Values = {"cutting_speed": 0.3 * FASTEST, "sigma1": 5.0, "release_time": 1e-5}
SOFT: Values = {"holder_compliance.compliance_x": 2e-7, "holder_compliance.compliance_y": 2e-7, "rake_angle": 0.1}
# Where an effect's starting values would not show within some cycles.
GIVEN: dict[str, Values] = {
    "holder_compliance": SOFT,
    "amplitude_loss": {"amplitude_loss.kappa": 0.5, "amplitude_loss.F_ref": 200.0, "amplitude_loss.response_time": 2e-5},
    "dynamometer_resonance": {"dynamometer_resonance.natural_period": 8e-5},
}
BESIDE = {"proxy_lag": ["thermal_softening"]}  # through which it shows
STATES = {effect.name: tuple(state.name for state in effect.states) for effect in kernel.effects() if effect.states}
SUMS = ("friction_impulse", "principal_impulse", "feed_impulse", "dissipated_energy")
MEASURED = tuple(f"measured_{name}" for name in SUMS[:3])
TOGETHER = [
    "holder_compliance",
    "amplitude_loss",
    "ellipse_phase_error",
    "run_out",
    "size_effect",
    "flow_stress_softening",
    "flank_wear",
    "process_damping",
    "cross_talk",
    "dynamometer_resonance",
    "sensor_lowpass",
    "sensor_gain",
    "sensor_offset",
    "sensor_drift",
]

with_states = pytest.mark.parametrize("name", STATES)


def nominal(states: tuple[str, ...]) -> np.ndarray:
    return np.array([kernel.variable(state).nominal for state in states])


def agree(values: Values, on: list[str], states: tuple[str, ...], cycles: float, rtol: float = 1e-8, close: float = 2e-6) -> None:
    """Radau at `rtol` and co-simulation at a hundredth of it: each adds up its errors over some thousand steps and a dozen events. Sums of
    forces by their own size, states by their nominal one."""
    own, host = (begun({**values, "relative_tolerance": 1e-2 * rtol}, on) for _ in range(2))
    own.advance(cycles * PERIOD)
    exchange(host, cycles * PERIOD, rtol, on)
    assert read(host, *SUMS, *MEASURED) == pytest.approx(read(own, *SUMS, *MEASURED), rel=close)
    assert read(host, *states) / nominal(states) == pytest.approx(read(own, *states) / nominal(states), abs=close)
    assert np.all(read(own, *SUMS) != 0)


# With entries and exits each of them; in one long cut two, and in the campaign all.
LONG = ("backlash", "maxwell_slip")


@pytest.mark.parametrize(
    ("name", "ratio"),
    [
        pytest.param(name, ratio, marks=pytest.mark.campaign if ratio > 1 and name not in LONG else ())
        for name in STATES
        for ratio in (0.3, 1.5)
    ],
)
def test_model_exchange_and_co_simulation_agree(name: str, ratio: float) -> None:
    """Two and a half cycles, of entries and exits or of one long cut in which friction reverses."""
    agree({**CUT, **GIVEN.get(name, {}), "cutting_speed": ratio * FASTEST}, [name, *BESIDE.get(name, [])], STATES[name], 2.5)


@pytest.mark.parametrize("values", [{"shear_angle_principle": "minimum_energy"}, {"friction_law": "coulomb", "rake_angle": -0.1}])
def test_a_compliant_holder_is_the_same_with_either_principle_and_law(values: Values) -> None:
    agree({**CUT, **SOFT, "holder_compliance.natural_frequency": 5e3, **values}, ["holder_compliance"], STATES["holder_compliance"], 2.5)


def test_effects_with_states_agree_beside_each_other() -> None:
    """All that feed back at once: the errors of one drive the next, and come to 1e-6 to 6e-6 at these and neighbouring values."""
    states = tuple(state for name in TOGETHER for state in STATES.get(name, ()))
    own = {"process_damping.C": 2e4, "flank_wear.feed_rate": 1e6, "run_out.spindle_frequency": 1e4}
    agree({**CUT, **SOFT, **GIVEN["amplitude_loss"], **GIVEN["dynamometer_resonance"], **own}, TOGETHER, states, 1.5, rtol=1e-9, close=2e-5)


@with_states
def test_a_tighter_tolerance_is_nearer(name: str) -> None:
    """Steps are chosen by the error of second order, (10 tolerance)^(3/5); what is summed over three cycles stays a tenth below."""
    on, names = [name, *BESIDE.get(name, [])], (*SUMS, *MEASURED, *STATES[name])

    def reached(tolerance: float) -> np.ndarray:
        contact = begun({**CUT, **GIVEN.get(name, {}), "relative_tolerance": tolerance}, on)
        contact.advance(3.3 * PERIOD)
        return read(contact, *names)

    exact, tolerances = reached(1e-12), np.array([1e-3, 1e-5, 1e-7, 1e-9])
    scale = np.append(np.abs(exact[: -len(STATES[name])]), nominal(STATES[name]))
    errors = np.array([np.abs((reached(tolerance) - exact) / scale).max() for tolerance in tolerances])
    assert np.all(errors < 0.1 * (10 * tolerances) ** 0.6)
    assert errors[0] > 30 * errors[3] > 0


@with_states
def test_states_move_along_straight_lines(name: str) -> None:
    """What averaging asks of an effect that does not forget: for a given drive the move of a weighted mean of states is the weighted mean
    of their moves, over a hundredth of a cycle and over a hundred. To rounding, which grows with the forces."""
    ffi, library = kernel.library()
    place = next(n for n in range(library.kernel_effect_count()) if kernel.effects()[n].name == name)
    effect = library.kernel_effect(place)
    if effect.forgets:
        pytest.skip("a separation resets its states: the cycle itself carries them")
    luck = np.random.default_rng(place)
    first = library.kernel_effect_switch(place)
    own = ffi.new("double[][1]", [[v.start] for v in kernel.variables()[first : first + effect.count]])
    points = [ffi.new("struct Point *") for _ in range(3)]
    for point in points:
        for field, kind in ffi.typeof("struct Point").fields:
            if kind.type.kind == "array" and kind.type.item.kind == "primitive":
                getattr(point, field)[0] = float(luck.uniform(0.5, 2))
    scale = nominal(STATES[name])

    def moved(state: np.ndarray, step: float) -> np.ndarray:
        rows = [ffi.new("double[][1]", [[value] for value in values]) for values in (state, 0 * state, 0 * state)]
        effect.move(own, ffi.new("double[1]", [step]), *points, *rows)
        return np.array([row[0] for row in rows[2]])

    for step in (0.01 * PERIOD, 100 * PERIOD):
        one, other = (luck.normal(0, scale) for _ in range(2))
        mean = 0.3 * moved(one, step) + 0.7 * moved(other, step)
        assert moved(0.3 * one + 0.7 * other, step) == pytest.approx(mean, rel=1e-9, abs=1e-9 * float(scale.max()))
    assert not np.array_equal(moved(one, 0.01 * PERIOD), moved(other, 0.01 * PERIOD))


@pytest.mark.parametrize("ratio", [0.3, 1.5])
def test_a_state_follows_the_slip_that_is_solved_for(ratio: float) -> None:
    """With chip_flow_angle = current_shear_angle the slip is not that of the motion alone, and a contact ages by the way that it slides."""
    values: Values = {**CUT, "chip_flow_angle": "current_shear_angle", "dwell_strengthening.D_c": 5e-6, "dwell_strengthening.t_ref": 1e-6}
    agree(
        {**values, "cutting_speed": ratio * FASTEST, "dwell_strengthening.beta": 0.5},
        ["dwell_strengthening"],
        STATES["dwell_strengthening"],
        2.5,
    )
