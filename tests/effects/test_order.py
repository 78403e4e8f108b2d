"""Does each state of an effect converge at the order that the integrator claims? Internal steps halved four times, against DOP853."""

from __future__ import annotations

import numpy as np
import pytest
from asking import begun
from driving import AMPLITUDE, ELLIPSE, OMEGA, PERIOD, Values, read
from evat.native import kernel
from exchange import put
from scipy.integrate import solve_ivp

ORDER = 4  # kernel/solver/tolerance.c: the error of a step is of h^5
STATES = {effect.name: tuple(state.name for state in effect.states) for effect in kernel.effects() if effect.states}
STATES["sticking_limit"] = ()  # it has none; the bristle strives for its limit
BEGIN, LENGTH, COUNTS = 0.05 * PERIOD, 0.4 * PERIOD, np.array([16, 32, 64, 128])
# A cut without separation or reversal, whose forces are smooth: all that happens is the integration.
SMOOTH: Values = {
    **ELLIPSE, "amplitude_y": 2e-6, "cutting_speed": 3 * AMPLITUDE * OMEGA, "feed": 1e-4, "chip_flow_shear_angle": 0.6, "sigma0": 1e6,
    "F_C": 9.0, "F_S": 12.0, "v_s": 0.5, "sigma1": 0.0, "sigma2": 1.0, "relative_tolerance": 1e-1,
}  # fmt: skip
# Times of the effect's own that are near the length of a step, so that its error stands above rounding.
OWN: dict[str, Values] = {
    "proxy_lag": {"proxy_lag.time_constant": 1e-5},
    "sensor_lowpass": {"sensor_lowpass.time_constant": 1e-5},
    "dynamometer_resonance": {"dynamometer_resonance.natural_period": 3e-5},
    "amplitude_loss": {"amplitude_loss.response_time": 1e-5, "amplitude_loss.F_ref": 200.0},
    "backlash": {"backlash.gap": 5e-4},
    "position_dependence": {"position_dependence.period": 2e-4},
    "maxwell_slip": {"maxwell_slip.stroke": 1e-3, "maxwell_slip.ratio": 1.0},
    "rate_and_state": {"rate_and_state.d_c": 2e-5, "rate_and_state.v_0": 0.1},
    "sticking_limit": {"sticking_limit.contact_length": 0.2},  # below F_C
    "dwell_strengthening": {"dwell_strengthening.D_c": 2e-5, "dwell_strengthening.t_ref": 1e-6},
}
BEGUN = {"backlash": 0.95}  # where its equation is smooth
BESIDE = {"proxy_lag": ("thermal_softening",)}  # through which it acts


@pytest.mark.parametrize("name", STATES)
def test_the_states_of_an_effect_converge_at_fourth_order(name: str) -> None:
    """One internal step each communication step, the tolerance wide open. The reference integrates what `rate` says; a step is `move`."""
    values, on = {**SMOOTH, **OWN.get(name, {})}, (name, *BESIDE.get(name, ()))
    states = ("bristle_deflection", *STATES[name])
    rate_of = {variable.derivative_of: variable.name for variable in kernel.variables()}
    twin = begun(values, on, BEGIN)
    start = read(twin, *states)
    start[0] = 9e-6
    start[1:] = BEGUN.get(name, start[1:])

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        put(twin, t, states, y)
        twin.evaluate()
        return read(twin, *(rate_of[state] for state in states))

    scale = np.array([kernel.variable(state).nominal for state in states])
    looks = BEGIN + LENGTH * np.arange(1, 9) / 8  # many, for an error may change its sign on the way
    exact = solve_ivp(rates, (BEGIN, looks[-1]), start, "DOP853", t_eval=looks, rtol=1e-12, atol=1e-14 * scale).y.T
    errors = []
    for count in COUNTS:
        contact = begun(values, on, BEGIN - 0.2 * PERIOD)  # the first steps after a start are short
        contact.advance(0.2 * PERIOD)
        put(contact, BEGIN, states, start)
        before, rows = contact.get("step_count"), []
        for n in range(count):
            contact.advance(LENGTH / count)
            if (n + 1) % (count // 8) == 0:
                rows.append(read(contact, *states))
        assert contact.get("step_count") - before == count
        errors.append(np.linalg.norm(np.array(rows) - exact, axis=0))
    slopes = -np.polyfit(np.log2(COUNTS), np.log2(np.array(errors)), 1)[0]
    assert slopes == pytest.approx(ORDER, abs=0.3), dict(zip(states, slopes, strict=True))
