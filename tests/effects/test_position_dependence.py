"""Do friction and force come back with the position, and with nothing else? Slides to and fro, and an equation of our own by scipy."""

from __future__ import annotations

from itertools import pairwise
from math import pi

import numpy as np
import pytest
from asking import OUTSIDE, begun, follow
from driving import Values, read
from evat.model import Run
from evat.native.batch import run_many
from evat.native.kernel import Contact
from scipy.integrate import solve_ivp

ON = ("position_dependence",)
F_C, SIGMA0, PERIOD, PSI, R, A = 6.0, 1e9, 3e-3, 0.7, 0.2, 1.3
LEVEL: Values = {**OUTSIDE, "sigma0": SIGMA0, "F_C": F_C, "F_S": F_C, "sigma1": 0.0, "sigma2": 0.0}
OWN: Values = {
    "position_dependence.friction": R,
    "position_dependence.cogging": A,
    "position_dependence.period": PERIOD,
    "position_dependence.phase": PSI,
}


@pytest.mark.parametrize("speed", [1e-3, 0.3])
def test_to_and_fro_the_ripple_stands_still_over_the_position(speed: float) -> None:
    """Friction turns round with the slip, what cogs does not; at any speed."""
    way = 2.3 * PERIOD
    times = np.linspace(0, 1, 93) * way / speed
    there = begun({**LEVEL, **OWN, "slip_velocity": speed}, ON)
    first = there.run(times, {}, ("friction_force", "position_dependence.position")).T
    there.set("slip_velocity", -speed)
    back = there.run(times[-1] + times, {}, ("friction_force", "position_dependence.position")).T
    for (force, position), sign in ((first, 1), (back, -1)):
        sine = np.sin(2 * pi * position / PERIOD + PSI)
        right = sign * F_C * (1 + R * sine) + A * sine
        np.testing.assert_allclose(force[3:], right[3:], atol=2e-4 * F_C)  # bristles of 6 nm, and their lag of it
    np.testing.assert_allclose(first[1], times * speed, atol=1e-9 * way)
    np.testing.assert_allclose(back[1][::-1], first[1], atol=1e-9 * way)


def test_what_cogs_takes_no_energy_over_a_period() -> None:
    """And of friction that ripples the mean is left. One step of a hundred periods, of which three points would tell nothing; and in a
    quarter of one more the integral of the sine."""
    values: Values = {**LEVEL, **OWN, "slip_velocity": 0.1}
    contact = begun(values, ON)
    names = ("dissipated_energy", "friction_impulse")
    contact.advance(PERIOD / 0.1)
    before = read(contact, *names)
    contact.advance(100 * PERIOD / 0.1)
    gained = read(contact, *names) - before
    assert gained == pytest.approx([100 * F_C * PERIOD, 1000 * F_C * PERIOD], rel=1e-7)
    before = read(contact, "friction_impulse")
    contact.advance(0.25 * PERIOD / 0.1)
    of_the_sine = (A + R * F_C) * (np.cos(PSI) - np.cos(pi / 2 + PSI)) / (2 * pi)
    gained = read(contact, "friction_impulse") - before
    assert gained == pytest.approx((0.25 * F_C + of_the_sine) * PERIOD / 0.1, rel=1e-5)


def test_an_uneven_slide_is_that_of_the_equation() -> None:
    """dz/dt and dx/dt by DOP853 at 1e-12, with stops, reversals and bursts over many periods."""
    values: Values = {**LEVEL, **OWN, "sigma0": 3e6}
    corners, speeds = np.array([0, 0.1, 0.3, 0.4, 0.5, 0.7]), np.array([1e-3, 0.2, 0.0, 0.0, -0.3, 0.05])
    times = np.linspace(0, 0.7, 141)
    force, position = follow(
        times, {"slip_velocity": np.interp(times, corners, speeds)}, values, ON, "friction_force", "position_dependence.position"
    )

    def rates(t: float, y: np.ndarray) -> list[float]:
        v = float(np.interp(t, corners, speeds))
        g = F_C * (1 + R * np.sin(2 * pi * y[1] / PERIOD + PSI))
        return [v - 3e6 * abs(v) / g * y[0], v]

    y, rows = np.zeros(2), [[A * np.sin(PSI), 0.0]]
    turn = 0.5 + 0.2 * 0.3 / 0.35
    for low, high in pairwise(np.unique(np.concatenate([times, corners, [turn]]))):
        y = solve_ivp(rates, (low, high), y, "LSODA", rtol=1e-10, atol=[1e-17, 1e-15]).y[:, -1]
        if np.min(np.abs(times - high)) < 1e-12:
            rows.append([3e6 * y[0] + A * np.sin(2 * pi * y[1] / PERIOD + PSI), y[1]])
    right = np.array(rows)[-len(times) :].T
    np.testing.assert_allclose(position, right[1], atol=1e-9 * PERIOD)
    np.testing.assert_allclose(force, right[0], atol=3e-6 * F_C)


@pytest.mark.parametrize("law", ["lugre", "dahl", "coulomb", "reset_integrator"])
@pytest.mark.parametrize(("release_time", "comes_back"), [(0.0, True), (2e-5, False)])
def test_a_periodic_start_is_one_or_says_that_there_is_none(law: str, release_time: float, comes_back: bool) -> None:
    """A chip begins anew after each separation, and its position with it; bristles that outlive one let the position go on for ever."""
    values = {"friction_law": law, "initial_state": "periodic", "release_time": release_time, "position_dependence.period": 1.2e-5}
    contact, means = Contact({**values, "cutting_speed": 0.15}, ["position_dependence"]), []
    contact.start()
    for _ in range(4):
        contact.advance(1 / 20e3)
        means.append(contact.get("mean_friction_force"))
    alike = means == pytest.approx([means[-1]] * 4, rel=1e-3)
    assert alike or any("no periodic steady state" in said for said in contact.warnings())
    assert alike or not comes_back


CYCLIC: Values = {"initial_state": "periodic", "cutting_speed": 0.15, "position_dependence.period": 1.2e-5}


def test_a_position_that_nothing_goes_by_leaves_the_periodic_start_as_it_is() -> None:
    """It goes on for ever where bristles outlive a separation, or where there is none, and no search for its cycle ended."""
    for release_time, cutting_speed in ((1.2e-6, 0.15), (2e-5, 0.15), (0.0, 0.8)):
        values = {**CYCLIC, "release_time": release_time, "cutting_speed": cutting_speed}
        beside = Contact({**values, "position_dependence.friction": 0.0, "position_dependence.cogging": 0.0}, ["position_dependence"])
        alone = Contact(values)
        for contact in (alone, beside):
            contact.start()
        assert not any("no periodic steady state" in said for said in beside.warnings())
        for name in ("friction_force", "principal_force", "bristle_deflection"):
            assert beside.get(name) == pytest.approx(alone.get(name), rel=1e-6), (name, release_time)


def test_lanes_that_seek_a_position_and_lanes_that_leave_it_begin_as_each_alone() -> None:
    """To the last bit, and with its own warning."""
    own = {"release_time": np.tile([0.0, 2e-5], 4), "position_dependence.friction": np.repeat([0.0, 0.2], 4)}
    settled: Values = {**CYCLIC, "position_dependence.cogging": 0.0}
    names = ("friction_force", "bristle_deflection", "position_dependence.position")
    run = Run(np.arange(4) / 40e3, {}, names)
    on = ("position_dependence", "thermal_softening")
    batch = run_many(run, {**settled, **own}, on)
    for place in range(8):
        alone = Contact({**settled, **{name: float(each[place]) for name, each in own.items()}}, on)
        alone.start()
        rows = alone.run(run.times, {}, names)
        assert all((batch.rows[name][place] == rows[:, column]).all() for column, name in enumerate(names)), place
        felt = own["position_dependence.friction"][place] > 0 and own["release_time"][place] > 0
        assert any("no periodic steady state" in said for said in alone.warnings()) == felt
