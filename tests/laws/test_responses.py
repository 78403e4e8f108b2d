"""Do linear states answer a parabola exactly, and ages its slip? Each effect's own step, against the matrix exponential and DOP853."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
from asking import CONSTANT, OUTSIDE, begun, course
from evat.native import kernel
from scipy.integrate import solve_ivp
from scipy.linalg import expm

U = (2.0, -1.0, 3.0)  # the drive at start, middle and end
DAMPING = (0.0, 0.05, 0.7, 1 - 1e-7, 1 - 1e-10, 1.0, 1 + 1e-10, 1 + 1e-7, 1.3, 2.0)


def moved(name: str, values: dict[str, float], state: list[float], h: float, **drive: tuple[float, float, float]) -> np.ndarray:
    """The states of the effect after half and whole of a step of h [s], shape (2, states); fields of the points at start, middle, end."""
    ffi, library = kernel.library()
    place = next(n for n, effect in enumerate(kernel.effects()) if effect.name == name)
    effect, first = library.kernel_effect(place), library.kernel_effect_switch(place)
    table = kernel.variables()[first : first + effect.count]
    own = ffi.new("double[][1]", [[values.get(v.name.partition(".")[2], v.start)] for v in table])
    points: list[Any] = [ffi.new("struct Point *") for _ in range(3)]
    for n, point in enumerate(points):
        for field, course_of in drive.items():
            if field == "measured":
                for channel in range(3):
                    point.measured[channel][0] = course_of[n]
            else:
                getattr(point, field)[0] = course_of[n]
    rows = [ffi.new("double[][1]", [[value] for value in given]) for given in (state, [0.0] * len(state), [0.0] * len(state))]
    effect.move(own, ffi.new("double[1]", [h]), *points, *rows)
    return np.array([[row[0] for row in part] for part in rows[1:]])


def exactly(A: np.ndarray, b: np.ndarray, y: list[float], h: float) -> np.ndarray:
    """y' = A y + b u(t) after half and whole of h, where u is the parabola through U: linear in (y, u, u', u'')."""
    n = len(y)
    u = [U[0], (4 * U[1] - 3 * U[0] - U[2]) / h, 4 * (U[0] - 2 * U[1] + U[2]) / h**2]
    whole = np.zeros((n + 3, n + 3))
    whole[:n, :n], whole[:n, n] = A, b
    whole[n, n + 1] = whole[n + 1, n + 2] = 1
    return np.array([(expm(whole * part) @ np.array([*y, *u]))[:n] for part in (h / 2, h)])


def with_mean(A: np.ndarray, b: np.ndarray, y: list[float], h: float) -> np.ndarray:
    """The same, but that the first state at the middle is what gives its integral over h by Simpson's rule: as sensors have it."""
    n = len(y)
    summed = np.zeros((n + 1, n + 1))
    summed[:n, :n], summed[n, 0] = A, 1
    exact = exactly(summed, np.append(b, 0), [*y, 0.0], h)
    exact[0, 0] = (6 * exact[1, n] / h - y[0] - exact[1, 0]) / 4
    return exact[:, :n]


@pytest.mark.parametrize("turn", [1e-3, 0.0499, 0.0501, 0.3, 2.0, 9.0])
@pytest.mark.parametrize("zeta", DAMPING)
def test_a_resonance_answers_a_parabola_exactly(zeta: float, turn: float) -> None:
    """Undamped, damped, at the limit and beyond, where it creeps; steps of a thousandth of a radian to nine. To rounding, which the
    parabola's division by the square of the step raises."""
    y = [0.7, -1.3]  # in units of 1/w, as the step is: then both are of one size
    period, w = 2 * pi / 50.0, 50.0
    of_middle = with_mean if turn > 1e-2 else exactly  # of a short step they are the same, and this test's own differences cancel
    exact = of_middle(np.array([[0, 1], [-1, -2 * zeta]]), np.array([0.0, 1.0]), y, turn)
    values = {"natural_period": period, "damping_ratio": zeta}
    response = moved("dynamometer_resonance", values, [y[0], y[1] * w] * 3, turn / w, measured=U)
    for channel in range(3):
        assert response[1, 2 * channel] == pytest.approx(exact[1, 0], abs=1e-10)
        assert response[0, 2 * channel] == pytest.approx(exact[0, 0], abs=1e-8)  # a difference over the step
        assert response[:, 2 * channel + 1] / w == pytest.approx(exact[:, 1], abs=1e-10)


@pytest.mark.parametrize("zeta", DAMPING)
def test_a_holder_gives_way_along_and_across_the_cut(zeta: float) -> None:
    """The same oscillator twice: against the principal force, along the feed force, each with its own compliance."""
    f, y, turn = 300.0, [2e-6, -3e-7], 1.1
    w = 2 * pi * f
    values = {"compliance_x": 1e-7, "compliance_y": 3e-8, "natural_frequency": f, "damping_ratio": zeta}
    response = moved("holder_compliance", values, [y[0], y[1] * w, y[0], y[1] * w], turn / w, F_p=U, F_f=U)
    for at, gain in ((0, -1e-7), (2, 3e-8)):
        exact = exactly(np.array([[0, 1], [-1, -2 * zeta]]), np.array([0.0, gain]), y, turn)
        assert response[:, at] == pytest.approx(exact[:, 0], abs=1e-17)
        assert response[:, at + 1] / w == pytest.approx(exact[:, 1], abs=1e-17)


@pytest.mark.parametrize("part", [1e-9, 1e-3, 0.5, 2.0, 60.0])
@pytest.mark.parametrize("name", ["sensor_lowpass", "proxy_lag", "amplitude_loss"])
def test_a_lag_answers_a_parabola_exactly(name: str, part: float) -> None:
    T, y = 2e-3, 0.7
    constant = "response_time" if name == "amplitude_loss" else "time_constant"
    field = {"sensor_lowpass": "measured", "proxy_lag": "theta_given", "amplitude_loss": "F_p"}[name]
    response = moved(name, {constant: T}, [y] * (3 if name == "sensor_lowpass" else 1), part * T, **{field: U})
    exact = (with_mean if name == "sensor_lowpass" and part > 1e-2 else exactly)(np.array([[-1.0]]), np.array([1.0]), [y], part)
    assert response == pytest.approx(np.tile(exact, (1, response.shape[1])), rel=1e-12, abs=1e-12)


def test_a_lag_that_is_none_or_hardly_begins() -> None:
    """No time constant: the drive itself. A step of 1e-15 time constants: by its own slope, and not nothing."""
    assert moved("sensor_lowpass", {"time_constant": 0.0}, [0.7] * 3, 1e-3, measured=U)[:, 1] == pytest.approx(U[1:], abs=0)
    response = moved("sensor_lowpass", {"time_constant": 1.0}, [0.0] * 3, 1e-15, measured=(2.0, 3.0, 4.0))[:, 0]
    assert response / 1e-15 == pytest.approx(
        [0.5 * 2, 3], rel=1e-9
    )  # half of it by the drive at the start, the whole by that of the middle


@pytest.mark.parametrize("zeta", [0.05, 0.9, 1.0, 1.1, 2.0])
def test_a_force_that_sets_in_is_measured_as_the_oscillator_says(zeta: float) -> None:
    """Through the door: a constant force from t = 0, 1 - e^(A t) of it at any time, creeping without overshoot from zeta = 1 on."""
    T = 3e-4
    values = {"dynamometer_resonance.natural_period": T, "dynamometer_resonance.damping_ratio": zeta}
    contact = begun({**OUTSIDE, **CONSTANT, "slip_velocity": 1.0, **values}, ["dynamometer_resonance"])
    times = T * np.array([0, 0.03, 0.2, 0.5, 1, 2, 5])
    shown, true = course(contact, times, "measured_friction_force", "friction_force")
    A = np.array([[0, 1], [-1, -2 * zeta]])
    exact = [1 - (expm(A * 2 * pi * t / T) @ np.array([1, 0]))[0] for t in times]
    assert shown / true == pytest.approx(exact, abs=1e-10)
    assert (shown.max() > 9.0) == (zeta < 1)


@pytest.mark.parametrize("renewals", [1e-9, 0.05, 0.6, 5.0, 100.0])
def test_a_contact_ages_to_the_time_of_its_renewal(renewals: float) -> None:
    """At a constant speed age - D_c/v is an exponential over the way; exact where the way is long, by Simpson's rule where it is short."""
    D_c, h, age = 1e-6, 1e-3, 4e-4
    speed, ones = renewals * D_c / h, (1.0, 1.0, 1.0)
    ages = moved("dwell_strengthening", {"D_c": D_c}, [age], h, cutting=ones, speed=(speed,) * 3)[:, 0]
    for value, way in zip(ages, (renewals / 2, renewals), strict=True):
        exact = age * np.exp(-way) - D_c / speed * np.expm1(-way)
        assert value == pytest.approx(exact, abs=h * way**4 / 2880 if way < 0.5 else 0, rel=1e-12)
    still = moved("dwell_strengthening", {"D_c": D_c}, [age], h, cutting=(0.0, 0.0, 0.0), speed=(speed,) * 3)
    assert np.all(still == age)


def test_a_contact_ages_at_fourth_order_whatever_its_slip() -> None:
    """age' = 1 - |v| age/D_c along a slip that swells, less than half D_c a step: the error is of h^5 at its end, of h^4 in its
    middle, which only serves."""
    D_c, age, ones = 1e-6, 4e-4, (1.0, 1.0, 1.0)

    def after(h: float, phase: float) -> np.ndarray:
        def speed(t: float) -> float:
            return 1e-3 * (1 + 0.8 * float(np.sin(900 * t + phase)))

        exact = solve_ivp(lambda t, y: 1 - speed(t) * y / D_c, (0, h), [age], "DOP853", t_eval=[h / 2, h], rtol=1e-13, atol=1e-20).y[0]
        speeds = (speed(0), speed(h / 2), speed(h))
        return moved("dwell_strengthening", {"D_c": D_c}, [age], h, cutting=ones, speed=speeds)[:, 0] - exact

    steps = 2e-4 / 2 ** np.arange(4)
    errors = [np.linalg.norm([after(h, phase) for phase in range(6)], axis=0) for h in steps]
    assert np.polyfit(np.log2(steps), np.log2(errors), 1)[0] == pytest.approx([4, 5], abs=0.3)
