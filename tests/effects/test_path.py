"""Do the effects on the path move the tool as mechanics says? Springs, ringing, a weaker or tilted ellipse, eccentric work."""

from __future__ import annotations

from math import cos, log, pi, sin, sqrt

import numpy as np
import pytest
from asking import CONSTANT, FASTEST, OUTSIDE, VISCOUS, begun, course, follow, line
from driving import AMPLITUDE, FREQUENCY, PERIOD, Values, events, read
from evat.native.kernel import Contact

HOLDER = ["holder_compliance"]
MOVED = tuple(f"holder_compliance.{name}" for name in ("displacement_x", "velocity_x", "displacement_y", "velocity_y"))
TURNING: Values = {**CONSTANT, "amplitude_x": 0.0, "amplitude_y": 0.0, "cutting_speed": 1.0}  # no vibration: one long cut
CUT: Values = {"cutting_speed": 0.3 * FASTEST, "initial_state": "periodic", "relative_tolerance": 1e-7}
CYCLE = ("friction_force", "principal_force", "feed_force", "slip_velocity_used", "uncut_thickness_used", "in_contact")
MEANS = ("mean_friction_force", "mean_principal_force", "mean_feed_force", "mean_contact_ratio", "speed_ratio")


def holder(f_n: float, zeta: float, c_x: float, c_y: float) -> dict[str, float]:
    named = {"natural_frequency": f_n, "damping_ratio": zeta, "compliance_x": c_x, "compliance_y": c_y}
    return {f"holder_compliance.{name}": value for name, value in named.items()}


def ring_down(contact: Contact, rest: float, frequency: float, zeta: float) -> None:
    """A displacement in y is let go: it comes back a damped period later, smaller by the logarithmic decrement, and crosses in between."""
    delta, damped = 2 * pi * zeta / sqrt(1 - zeta**2), frequency * sqrt(1 - zeta**2)
    contact.set(MOVED[2], rest + 1e-6)
    periods = [(contact.advance(1 / damped), read(contact, *MOVED[2:]) - [rest, 0])[1] for _ in range(3)]
    assert [log(1e-6 / y) for y, _ in periods] == pytest.approx(delta * np.arange(1, 4), rel=1e-6)
    assert [u for _, u in periods] == pytest.approx(3 * [0], abs=1e-6 * 2 * pi * frequency * 1e-6)


def test_holder_gives_way_by_compliance_times_force() -> None:
    """At rest: against the cut by c_x F_p, away from the surface by c_y F_f, which makes the chip thinner by as much."""
    c_x, c_y = 3e-8, 2e-7
    contact = begun({**TURNING, **holder(2e3, 1.0, c_x, c_y)}, HOLDER)
    contact.advance(1e-2)
    F_p, F_f, h = read(contact, "principal_force", "feed_force", "uncut_thickness_used")
    thickness = 1e-4 - c_y * 9
    assert (F_f, h, F_p) == pytest.approx((9, thickness, 2 * 4e8 * 1e-3 * thickness + 9), rel=1e-9)  # N = 2 k + F at no rake
    assert read(contact, *MOVED) == pytest.approx([-c_x * F_p, 0, c_y * F_f, 0], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("zeta", [0.0, 0.03, 0.4])
def test_holder_rings_down_freely(zeta: float) -> None:
    contact = begun({**OUTSIDE, "uncut_thickness": -1e-4, **holder(2e3, zeta, 2e-8, 2e-8)}, HOLDER)
    ring_down(contact, 0.0, 2e3, zeta)


def test_holder_in_a_cut_has_the_cuttings_stiffness_too() -> None:
    """With a rake the feed force grows as the tool springs out: F_f = ... + K y, K = 2 tau_s w sin(alpha)/(cos(alpha) + sin(alpha)), so the
    natural frequency falls by sqrt(1 - c K); its damping, per mass, stays."""
    rake, c, f_n, zeta = 0.3, 1e-6 / 5, 1e3, 0.05
    contact = begun({**TURNING, "rake_angle": rake, **holder(f_n, zeta, 0.0, c)}, HOLDER)
    K = 2 * 4e8 * 1e-3 * sin(rake) / (cos(rake) + sin(rake))
    contact.advance(0.1)
    lower = sqrt(1 - c * K)
    ring_down(contact, contact.get(MOVED[2]), f_n * lower, zeta / lower)


def test_friction_damps_the_holder() -> None:
    """Viscous friction along the rake is a damper on the holder's motion across: zeta + sigma2 c_y w_n/2."""
    f_n, zeta, c, sigma2 = 1e3, 0.02, 1e-7, 50.0
    values = {**OUTSIDE, **VISCOUS, "relative_tolerance": 1e-10, "sigma2": sigma2, "slip_velocity": 1.0, **holder(f_n, zeta, 0.0, c)}
    contact = begun(values, HOLDER)
    contact.advance(0.1)
    ring_down(contact, contact.get(MOVED[2]), f_n, zeta + 0.5 * sigma2 * c * 2 * pi * f_n)


@pytest.mark.parametrize(("part", "cycles"), [(1.0, 16), (10.0, 160), (0.01, 1)])
def test_holder_resonates(part: float, cycles: int) -> None:
    """A thickness that swings is a principal force that swings, and constant friction leaves the holder alone: c_x/(2 zeta) and a quarter
    turn at f_n, 1/99 of c_x nearly half a turn late at 10 f_n, and c_x far below."""
    f_n, zeta, c_x, samples = 2e3, 0.2, 2e-8, 400
    times = np.arange((cycles + 1) * samples) / (samples * part * f_n)
    thickness = 1e-4 + 2e-5 * np.sin(2 * pi * part * f_n * times)
    values = {**CONSTANT, "slip_velocity": 1.0, **holder(f_n, zeta, c_x, 0.0)}
    rows = follow(times, {"uncut_thickness": thickness}, values, HOLDER, "principal_force", MOVED[0])
    force, moved = line(part * f_n, times[-samples:], rows[:, -samples:])
    exact = 1 / (1 - part**2 + 2j * zeta * part)
    assert abs(force) == pytest.approx(2 * 4e8 * 1e-3 * 2e-5, rel=1e-6)
    # straight between samples: (sin x/x)^2 less in the line, and neighbours of it that pass as 1/samples^2
    assert -moved / force / np.sinc(1 / samples) ** 2 == pytest.approx(c_x * exact, rel=1e-4 if part >= 1 else 1e-3)


def test_stiff_holder_is_the_rigid_tool() -> None:
    """The gap closes in proportion to the compliance."""
    times = np.linspace(0, 2 * PERIOD, 200)
    rigid = course(begun(CUT), times, "principal_force")
    gaps = []
    for c in (1e-10, 1e-9, 1e-8):
        given = course(begun({**CUT, **holder(2e3, 0.03, c, c)}, HOLDER), times, "principal_force")
        gaps.append(np.median(np.abs(given - rigid)[rigid > 0]))
    assert gaps == pytest.approx(gaps[0] * np.array([1, 10, 100]), rel=3e-3)  # a micron per 100 N: what is quadratic shows at 1e-8 m/N
    assert gaps[0] < 1e-5 * rigid.max()


@pytest.mark.parametrize(("ratio", "zeta"), [(0.3, 0.0), (0.3, 2.0), (1.5, 0.03), (1.5, 2.0)])
@pytest.mark.parametrize("c", [1e-14, 2e-7])
@pytest.mark.parametrize("f_n", [1.0, 5e3])
def test_holder_is_stable_at_its_corners(f_n: float, c: float, ratio: float, zeta: float) -> None:
    """Stiff or soft, slow or fast, damped or not: a force that sets in and stays, or pulses, moves an oscillator by at most twice c F. (In
    a long cut friction that falls with speed excites an undamped holder of itself, as it does in nature.)"""
    values = {"cutting_speed": ratio * FASTEST, "relative_tolerance": 1e-5, **holder(f_n, zeta, c, c)}
    rows = course(begun(values, HOLDER), np.linspace(0, 100 * PERIOD, 4000), MOVED[0], MOVED[2], "principal_force", "feed_force")
    assert np.all(np.abs(rows[:2]).max(axis=1) <= 2.01 * c * np.abs(rows[2:]).max(axis=1))
    assert np.abs(rows[:2]).max() > 0


def test_holders_energy_balances_over_a_cycle() -> None:
    """Periodic: the work of the forces on the holder is what its dampers take, 2 zeta/(c w) u^2 in x and in y. Gauss's rule between the
    events, of which a copy tells the times."""
    f_n, zeta, c_x, c_y = 5e3, 0.1, 4e-8, 1e-7
    contact = begun({**CUT, "sigma2": 5.0, **holder(f_n, zeta, c_x, c_y)}, HOLDER)
    cuts = np.unique([0, *(time for time, *_ in events(contact.copy(), PERIOD)), *np.linspace(0, PERIOD, 401)])
    nodes, weights = np.polynomial.legendre.leggauss(4)
    times = (cuts[:-1, None] + 0.5 * np.diff(cuts)[:, None] * (1 + nodes)).ravel()
    share = (0.5 * np.diff(cuts)[:, None] * weights).ravel()
    names = ("tool_force_x", "tool_force_y", MOVED[1], MOVED[3])
    force_x, force_y, u_x, u_y = course(contact, np.append(0, times), *names)[:, 1:]
    work = [share @ (force_x * u_x), share @ (force_y * u_y)]
    taken = [2 * zeta / (c * 2 * pi * f_n) * (share @ u**2) for c, u in ((c_x, u_x), (c_y, u_y))]
    assert min(taken) > 0
    assert work == pytest.approx(taken, rel=2e-5)  # of a work that goes to and fro some hundredfold, to the tolerance of 1e-7


@pytest.mark.parametrize("ratio", [0.3, 1.5])
def test_amplitude_loss_is_a_tool_that_vibrates_less(ratio: float) -> None:
    """With a slow ultrasonic system the periodic cut is that of a tool with amplitudes smaller by 1 - kappa F_mean/F_ref, about the same
    centre: its lowest point, from which feed counts, is higher. The ripple of the mean force is a cycle's share of the response time."""
    kappa, F_ref, T = 0.2, 50.0, 10.0
    values = {**CUT, "cutting_speed": ratio * FASTEST}
    own = {"amplitude_loss.kappa": kappa, "amplitude_loss.F_ref": F_ref, "amplitude_loss.response_time": T}
    loaded = begun({**values, **own}, ["amplitude_loss"])
    loaded.advance(PERIOD)
    left = 1 - kappa * loaded.get("mean_principal_force") / F_ref
    b = AMPLITUDE * left
    smaller = begun({**values, "amplitude_x": b, "amplitude_y": b, "feed": 1e-4 - AMPLITUDE + b})
    smaller.advance(PERIOD)
    assert 0.5 < left < 0.95
    assert read(loaded, *MEANS) == pytest.approx(read(smaller, *MEANS), rel=PERIOD / T)
    assert loaded.get("speed_ratio") == pytest.approx(ratio / left, rel=PERIOD / T)


@pytest.mark.parametrize("delta", [-0.4, 0.25])
def test_phase_error_is_a_tool_that_runs_out_of_phase(delta: float) -> None:
    times = np.linspace(0, 2 * PERIOD, 100)
    tilted = begun({**CUT, "ellipse_phase_error.delta": delta}, ["ellipse_phase_error"])
    meant = begun({**CUT, "phase_y": pi + delta})
    rows, exact = course(tilted, times, *CYCLE), course(meant, times, *CYCLE)
    assert rows == pytest.approx(exact, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("shear_stress", [2e8, 6e8])
def test_run_out_makes_the_spindles_line_whatever_the_feed(shear_stress: float) -> None:
    """Where the nominal surface stands: a line of 2 tau_s w e in the principal force at the spindle's frequency, none at its harmonics; the
    cycle means keep sin(x)/x of it, x = pi f_spindle/f."""
    e, spindle, cycles = 4e-6, 500.0, 40
    lines = []
    for feed in (3e-5, 1e-4, 3e-4):
        values = {**CONSTANT, "cutting_speed": 1.5 * FASTEST, "feed": feed, "shear_stress": shear_stress, "amplitude_y": 2e-6}
        own = {"run_out.amplitude": e, "run_out.spindle_frequency": spindle, "run_out.phase": pi / 2}
        times = np.arange(cycles + 1) * PERIOD
        mean = course(begun({**values, **own}, ["run_out"]), times, "mean_principal_force")[0, 1:]
        lines.append([line(k * spindle, times[1:] - PERIOD / 2, mean) for k in (1, 2, 3)])
    exact = 2 * shear_stress * 1e-3 * e * np.sinc(spindle / FREQUENCY)
    assert np.array(lines) == pytest.approx(np.tile([exact, 0, 0], (3, 1)), rel=1e-6, abs=1e-6 * exact)


def test_the_tool_comes_near_by_the_holders_swing_alone() -> None:
    """The ellipse moves away and the holder swings back faster: contact begins where it is, whatever the step that leads there."""
    values: Values = {
        "vibration_frequency": 410.0, "amplitude_x": 4.876e-6, "amplitude_y": 1.0853e-6, "feed": 1.13e-6, "chip_flow_shear_angle": 0.584,
        "phase_x": -1.6822, "phase_y": 3.2383, "rake_angle": -0.1215, "cutting_speed": 0.012894, "relative_tolerance": 1e-5,
        "holder_compliance.compliance_x": 9.2e-8, "holder_compliance.compliance_y": 4.614e-8,
        "holder_compliance.natural_frequency": 4223.5, "holder_compliance.damping_ratio": 0.0612,
    }  # fmt: skip
    in_contact = []
    for steps in (1, 7, 300):
        contact = begun(values, ["holder_compliance"])
        contact.advance(5.13e-4)
        assert contact.get("in_contact") == 0
        for _ in range(steps):
            contact.advance(7e-5 / steps)
        in_contact.append(contact.get("contact_time"))
    assert in_contact[0] > 4.99e-4
    assert np.ptp(in_contact) < 1e-9


def test_forces_that_come_back_little_settle_at_any_tolerance() -> None:
    """Differences of passes that were nearly one another's multiples led a pass astray, and the next ones then followed a millionth of
    what they missed: at tolerances of 3e-6 and less no step longer than a billionth of a cycle settled, and no cycle came back."""
    values: Values = {
        "friction_law": "lugre", "damping_mode": "as_published", "chip_flow_angle": "current_shear_angle", "initial_state": "periodic",
        "sigma0": 422159.423731385, "sigma1": 145.93824277903383, "sigma2": 1.2819103290249303, "F_C": 0.5599336377802208,
        "F_S": 0.6809232478040678, "v_s": 0.012461574021773662, "lugre.presliding_exponent": 0.8504020608464925,
        "lugre.viscous_exponent": 1.710016886603714, "vibration_frequency": 17655.64980106648, "amplitude_x": 1.7029845212209972e-06,
        "amplitude_y": 1.1513110150141857e-05, "feed": 2.6352146872770352e-05, "chip_flow_shear_angle": 0.5280492841998603,
        "phase_x": -1.4549571373567156, "phase_y": 3.4232936367588365, "cutting_speed": 0.04261098496876287,
        **holder(1482.352262648607, 0.015220784051219984, 4.890332851723792e-09, 1.2064080873647161e-08),
    }  # fmt: skip
    means = []
    for tolerance in (1e-4, 1e-6, 5e-7, 1e-9):
        contact = Contact({**values, "relative_tolerance": tolerance}, HOLDER)
        contact.start()
        assert not contact.warnings()
        contact.advance(2 / values["vibration_frequency"])
        means.append(contact.get("mean_feed_force"))
    assert means[:3] == pytest.approx([means[3]] * 3, rel=3e-5)
