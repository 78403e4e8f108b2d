"""Is one cycle a fair stand-in for all cycles of a step? averaging = cycle against the run that follows every cycle."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import numpy as np
import pytest
from evat.model import FloatArray, SimulationError
from evat.native import kernel
from evat.native.kernel import Contact

FREQUENCY = 20e3
PERIOD = 1 / FREQUENCY
FORCES = ("friction", "principal", "feed")
IMPULSES = tuple(f"{name}_impulse" for name in FORCES)
INTEGRALS = (*IMPULSES, "normal_impulse", "contact_time", "dissipated_energy", "sliding_distance")
FACTOR = 3  # averaging_error may be too small by this, as kernel/averaging/average.c estimates and does not prove
Values = Mapping[str, float | str]


def speed(t: FloatArray) -> FloatArray:
    """Cutting speed [m/s] that rises by half within 50 ms, and wavers."""
    return 1 / 6 + 1.6 * t + 0.02 * np.sin(2 * np.pi * 40 * t)


def jump(t: FloatArray) -> FloatArray:
    """From 0.15 to 0.4 m/s within one step of the communication, whatever that is."""
    return np.where(t < 0.0205, 0.15, 0.4)


def run(averaging: str, values: Values, on: tuple[str, ...], times: FloatArray, at: FloatArray, names: tuple[str, ...]) -> FloatArray:
    contact = Contact({**values, "averaging": averaging, "cutting_speed": float(at[0])}, on)
    contact.start(times[0])
    return contact.run(times, {"cutting_speed": at}, names)


def means(averaging: str, values: Values, on: tuple[str, ...], times: FloatArray, at: FloatArray) -> FloatArray:
    """Mean forces over each step, shape (n, 3)."""
    return np.diff(run(averaging, values, on, times, at, IMPULSES), axis=0) / np.diff(times)[:, None]


@pytest.mark.parametrize("law", kernel.variable("friction_law").choices)
@pytest.mark.parametrize("cut", ["with separation", "without"])
def test_a_steady_cut_has_the_same_means(law: str, cut: str) -> None:
    """Nothing changes, so one cycle is like the others: forces to what the tolerance of 1e-4 leaves in both, duty to that of events. From
    the second millisecond on, when the start is forgotten in both."""
    values: Values = {"friction_law": law, "applied_force": 5.0}
    if cut == "without":
        values = {**values, "amplitude_x": 1e-6, "cutting_speed": 0.4}
    means = []
    for averaging in ("resolved", "cycle"):
        contact = Contact({**values, "averaging": averaging})
        contact.start()
        contact.advance(2e-3)
        begin = np.array([contact.get(name) for name in INTEGRALS])
        contact.advance(2e-3)
        means.append((np.array([contact.get(name) for name in INTEGRALS]) - begin) / 2e-3)
    resolved, averaged = means
    if law == "bristle" and cut == "without":  # its bristles break when they are bent, not when the cycle is round: the means are rough
        assert np.abs(averaged[:3] - resolved[:3]).max() <= FACTOR * contact.get("averaging_error")
        assert any("periodic" in line for line in contact.warnings())
        return
    assert contact.warnings() == ()
    assert averaged == pytest.approx(resolved, rel=3e-4, abs=3e-4 * 10 * 1e-3)
    assert averaged[4] == pytest.approx(resolved[4], rel=1e-6)


def test_a_step_costs_one_cycle_whatever_its_length() -> None:
    """Where bristles are let go at separation. 1 to 1000 cycles in a step; the tolerance's steps of one cycle do not change."""
    contact = Contact({"averaging": "cycle"})
    contact.start()
    contact.advance(PERIOD)
    costs = []
    for step in (PERIOD, 20 * PERIOD, 1000 * PERIOD, 7.3 * PERIOD):
        before = contact.get("step_count")
        contact.advance(step)
        costs.append(contact.get("step_count") - before)
    resolved = Contact()
    resolved.start()
    resolved.advance(PERIOD)
    before = resolved.get("step_count")
    resolved.advance(PERIOD)
    one = resolved.get("step_count") - before
    assert max(costs) <= 1.2 * one
    assert min(costs) >= 0.8 * one


@pytest.mark.parametrize("values", [{"release_time": 1e-4}, {"amplitude_x": 1e-6}])
def test_bristles_that_outlive_a_cycle_cost_a_second_one_now_and_then(values: Values) -> None:
    """What it tells serves 30 steps in which little changes: 200 steps of 1 ms cost little more than 200 cycles, of 4000; events that move
    on from step to step are aimed at in vain, for a short step each. Impulses agree to the half cycle by which the cycle may lie beside
    the middle: 25 us of 200 ms in which the forces rise by a quarter."""
    values = {**values, "initial_state": "periodic", "relative_tolerance": 1e-6}
    times = 1e-3 * np.arange(201)
    rising = 0.2 + 0.5 * times
    resolved, averaged = (run(averaging, values, (), times, rising, ("step_count", *IMPULSES)) for averaging in ("resolved", "cycle"))
    assert averaged[-1, 0] < 1.25 * resolved[-1, 0] / 20
    assert averaged[-1, 1:] == pytest.approx(resolved[-1, 1:], rel=3e-5)


def test_halving_the_step_quarters_the_error() -> None:
    """Inputs at the middle of the step: second order. At 1 MHz, where the half cycle by which the cycle may lie beside the middle (first
    order in the period) is small; the truth is resolved, at samples so dense that they are straight between."""
    values: Values = {"vibration_frequency": 1e6, "amplitude_x": 1e-7, "amplitude_y": 1e-7, "relative_tolerance": 1e-7}

    def speed(t: FloatArray) -> FloatArray:
        return 0.3 + 0.1 * np.sin(2 * np.pi * 50 * t)

    fine = np.linspace(0, 0.016, 641)
    truth = run("resolved", values, (), fine, speed(fine), IMPULSES)
    errors = []
    for count in (8, 16, 32):
        times = np.linspace(0, 0.016, count + 1)
        exact = np.diff(truth[:: 640 // count], axis=0) / np.diff(times)[:, None]
        errors.append(np.abs(means("cycle", values, (), times, speed(times)) - exact).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx([2, 2], abs=0.25)


CASES: dict[str, tuple[Values, tuple[str, ...]]] = {
    "start values": ({}, ()),
    "bristles that are not let go": ({"release_time": 1e-4}, ()),
    "no separation": ({"amplitude_x": 1e-7, "amplitude_y": 1e-7}, ()),
    "bristles of 200 cycles": ({"amplitude_x": 0.0, "sigma0": 1e4}, ()),
    "dahl": ({"friction_law": "dahl"}, ()),
    "reset_integrator": ({"friction_law": "reset_integrator"}, ()),
    "own shear angle": ({"chip_flow_angle": "current_shear_angle"}, ()),
    "periodic": ({"initial_state": "periodic"}, ()),
    "holder": ({}, ("holder_compliance",)),
    "amplitude": ({"amplitude_loss.kappa": 0.03}, ("amplitude_loss",)),
    "wear": ({}, ("flank_wear", "friction_wear")),
    "run-out, regeneration": ({}, ("run_out", "regenerative")),
    "heat": ({"proxy_source": "cutting_speed"}, ("thermal_softening", "thermal_damping", "proxy_lag")),
    "dwell": ({}, ("dwell_strengthening",)),
}


@pytest.mark.parametrize("law", ["coulomb", "lugre"])
@pytest.mark.parametrize("speed", [0.25, 0.3])
def test_an_amplitude_that_runs_away_is_followed(law: str, speed: float) -> None:
    """A force takes from the amplitude, and so makes itself grow until the tool leaves the chip no more: steps of 20 cycles said 1/24 of
    the error while they strove to what the step before had shown alone."""
    times = 1e-3 * np.arange(11)
    runs = [means(averaging, {"friction_law": law}, ("amplitude_loss",), times, speed + 0 * times) for averaging in ("resolved", "cycle")]
    said = run("cycle", {"friction_law": law}, ("amplitude_loss",), times, speed + 0 * times, ("averaging_error",))[1:, 0]
    assert (np.abs(runs[1] - runs[0]).max(axis=1) <= FACTOR * said).all()


# Where slip and shear angle are solved for, a run takes seconds: of the steps the first and the last, each in one of the motions; the
# campaign adds the others.
SLOW = {("own shear angle", step, motion) for step in (1e-4, 1e-3, 5e-3) for motion in (speed, jump)}
SLOW -= {("own shear angle", 1e-4, speed), ("own shear angle", 5e-3, jump)}


@pytest.mark.parametrize(
    ("case", "step", "motion"),
    [
        pytest.param(*each, marks=pytest.mark.campaign if each in SLOW else ())
        for each in itertools.product(CASES, (1e-4, 1e-3, 5e-3), (speed, jump))
    ],
)
def test_the_error_is_what_the_contact_says(case: str, step: float, motion: object) -> None:
    """In every step of 50 ms. Not above three times what averaging_error says, and not so far below that it says nothing: in half of the
    steps the estimate is below 15 times the error, or below a hundredth of the force."""
    values, on = CASES[case]
    times = step * np.arange(round(0.05 / step) + 1)
    at = motion(times)  # type: ignore[operator]
    resolved, averaged = (means(averaging, values, on, times, at) for averaging in ("resolved", "cycle"))
    said = run("cycle", values, on, times, at, ("averaging_error",))[1:, 0]
    error = np.abs(averaged - resolved).max(axis=1)
    assert (error <= FACTOR * said).all(), (error / said).max()
    assert np.median(said - np.maximum(15 * error, 1e-2 * np.abs(resolved).max())) < 0


@pytest.mark.parametrize(("turns", "step"), [(200.0, 5e-3), (190.0, 5e-3), (60.0, 5e-3), (20.0, 1e-3), (800.0, 5e-3), (1870.0, 5e-3)])
def test_a_surface_that_runs_out_within_a_step_has_the_mean_of_its_turns(turns: float, step: float) -> None:
    """About one turn a step, a part of one, and many: every cycle that stood for a step fell on nearly the same place of the turn, and the
    estimate knew of nothing but differences between steps."""
    own = {"run_out.amplitude": 2e-5, "run_out.spindle_frequency": turns, "run_out.phase": 0.5}
    times = step * np.arange(9)
    resolved, averaged = (means(averaging, own, ("run_out",), times, np.full(9, 1 / 6)) for averaging in ("resolved", "cycle"))
    said = run("cycle", own, ("run_out",), times, np.full(9, 1 / 6), ("averaging_error",))[1:, 0]
    error = np.abs(averaged - resolved).max(axis=1)
    assert (error <= FACTOR * said).all()
    few = turns * step < 4
    assert error.max() < (0.01 if few else 0.03) * resolved.max()
    assert np.median(said) < (0.03 if few else 0.3) * resolved.max()


BROKEN: dict[str, tuple[Values, tuple[str, ...]]] = {
    "start values": ({}, ()),
    "hard and late": ({"amplitude_x": 2e-6, "amplitude_y": 2e-6, "release_time": 1e-5}, ()),
    "soft": ({"amplitude_x": 2e-6, "sigma0": 1.5e4}, ()),
    "coulomb": ({"friction_law": "coulomb"}, ()),
    "viscous": ({"sigma2": 10.0}, ()),
    "softened": ({"proxy_source": "cutting_speed"}, ("thermal_softening",)),
}


@pytest.mark.parametrize("cycles", [0.4, 1.54, 2.2, 7.3, 20.5])
@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_cycle_is_in_the_error(case: str, cycles: float) -> None:
    """Steps that hold no whole number of cycles: the piece may hold all of a cycle's force, or none. Before, the estimate was exceeded by
    factors of 100 to 2900. And it says something: in half of the steps it is below 15 times the error, or a quarter of the force."""
    values, on = BROKEN[case]
    times = cycles * PERIOD * np.arange(round(0.02 / (cycles * PERIOD)) + 1)
    at = speed(times)
    resolved, averaged = (means(averaging, values, on, times, at) for averaging in ("resolved", "cycle"))
    said = run("cycle", values, on, times, at, ("averaging_error",))[1:, 0]
    error = np.abs(averaged - resolved).max(axis=1)
    assert (error <= FACTOR * said).all(), (error / said).max()
    assert np.median(said - np.maximum(15 * error, 0.25 * np.abs(resolved).max())) < 0


@pytest.mark.parametrize("step", [1e-4, 5e-4, 1e-3])
@pytest.mark.parametrize("motion", [speed, jump])
@pytest.mark.parametrize(
    "values",
    [
        {"amplitude_x": 5e-7, "amplitude_y": 2e-6, "sigma0": 1.08e4},
        {"amplitude_x": 1e-6, "amplitude_y": 1e-6, "sigma0": 5.3e4, "release_time": 1e-4},
        {"amplitude_x": 1e-6, "amplitude_y": 5e-6, "sigma0": 3.5e4, "release_time": 1e-4, "initial_state": "periodic"},
    ],
)
def test_a_law_that_breaks_away_once_in_many_cycles_says_so(values: Values, motion: object, step: float) -> None:
    """reset_integrator whose bristles are bent over tens of cycles. Up to 8 cycles are those of the step itself; of more, nobody knows
    where the bristles stand. Before, the estimate was exceeded by factors of 20 to 570."""
    values = {"friction_law": "reset_integrator", **values}
    times = step * np.arange(round(0.02 / step) + 1)
    at = motion(times)  # type: ignore[operator]
    resolved, averaged = (means(averaging, values, (), times, at) for averaging in ("resolved", "cycle"))
    said = run("cycle", values, (), times, at, ("averaging_error",))[1:, 0]
    error = np.abs(averaged - resolved).max(axis=1)
    assert (error <= FACTOR * said).all(), (error / said).max()


def both(values: Values, effect: str) -> tuple[Contact, Contact]:
    """The same contact averaged and resolved, begun."""
    averaged, resolved = (Contact({**values, "averaging": averaging}, [effect]) for averaging in ("cycle", "resolved"))
    averaged.start()
    resolved.start()
    return averaged, resolved


def within_the_error(contacts: tuple[Contact, Contact], steps: int) -> bool:
    """Whether in all of so many steps of 20 cycles the mean friction forces differ by no more than the averaged contact says."""
    fine = True
    for _ in range(steps):
        forces = []
        for contact in contacts:
            before = contact.get("friction_impulse")
            contact.advance(20 * PERIOD)
            forces.append((contact.get("friction_impulse") - before) / (20 * PERIOD))
        fine &= abs(forces[0] - forces[1]) <= FACTOR * contacts[0].get("averaging_error") + 1e-9
    return fine


@pytest.mark.parametrize("law", ["lugre", "karnopp", "coulomb"])
@pytest.mark.parametrize("cutting_speed", [0.031, 0.1, 0.7, 1.25])
@pytest.mark.parametrize("gap", [2e-5, 1e-4, 1e-3])
def test_a_gap_that_a_separation_does_not_reset_is_crossed_in_as_many_cycles(law: str, cutting_speed: float, gap: float) -> None:
    """Its place drifts from cycle to cycle. A step moved it by a single cycle, whatever its length: no force where there was one for ever,
    with an error that grew less with each step."""
    contacts = both({"friction_law": law, "release_time": 1e-5, "cutting_speed": cutting_speed, "backlash.gap": gap}, "backlash")
    assert within_the_error(contacts, 15)
    gained = []
    for contact in contacts:
        before = contact.get("dissipated_energy")
        contact.advance(100 * PERIOD)
        gained.append(contact.get("dissipated_energy") - before)
    on_its_way = gap == 1e-3 and cutting_speed < 0.1  # 64 of the hundred cycles are run, and the end of the gap lies among them
    assert gained[0] == pytest.approx(gained[1], rel=0.05 if on_its_way else 2e-3, abs=1e-9)


@pytest.mark.parametrize(
    ("effect", "values"),
    [
        ("maxwell_slip", {"maxwell_slip.stroke": 1e-3, "release_time": 1e-3}),
        ("position_dependence", {"position_dependence.period": 1e-4, "release_time": 1.0}),
        ("rate_and_state", {"rate_and_state.d_c": 1e-2, "release_time": 1.0}),
    ],
)
def test_what_drifts_in_all_cycles_says_so(effect: str, values: Values) -> None:
    """Elements, places and memories that outlive a separation and are long on their way: the error is what the contact says, and the
    warning says that no cycle is like the next."""
    contacts = both(values, effect)
    assert within_the_error(contacts, 8)
    assert any("periodic" in line for line in contacts[0].warnings())


def test_energies_and_distance_advance_by_their_means() -> None:
    """Over 50 ms in which the cutting speed rises: to a thousandth, as the first cycle at rest is one of a thousand."""
    times = 1e-3 * np.arange(51)
    resolved, averaged = (run(averaging, {}, (), times, speed(times), INTEGRALS)[-1] for averaging in ("resolved", "cycle"))
    assert averaged == pytest.approx(resolved, rel=1e-3)


def test_a_slow_filter_hears_the_means() -> None:
    """A low-pass of 3 ms behind forces of 20 kHz: the ripple that is left, a part in 3 ms 2 pi 20 kHz = 377 of the force's own, is all that
    both may differ by; and the mean over the step."""
    values, on = {"sensor_lowpass.time_constant": 3e-3}, ("sensor_lowpass",)
    times = 1e-3 * np.arange(21)
    names = ("measured_principal_impulse", "sensor_lowpass.principal_force")
    resolved, averaged = (run(averaging, values, on, times, speed(times), names) for averaging in ("resolved", "cycle"))
    force = resolved[-1, 1]
    assert np.abs(averaged - resolved)[:, 0].max() <= 1e-3 * resolved[-1, 0]
    assert np.abs(averaged - resolved)[:, 1].max() <= 0.02 * force
    assert resolved[2, 1] < 0.6 * force  # the filter was still rising


def test_a_delay_of_one_step_shows_the_step_before() -> None:
    contact = Contact({"averaging": "cycle", "sensor_delay.time": 1e-3}, ("sensor_delay",))
    contact.start()
    begun, rows = contact.get("principal_force"), []
    for value in (0.1, 0.2, 0.3, 0.25):
        contact.set("cutting_speed", value)
        contact.advance(1e-3)
        rows.append((contact.get("principal_force"), contact.get("measured_principal_force")))
    forces, measured = np.array(rows).T
    jumps = np.abs(np.diff(forces, prepend=begun))  # fall on a start or an end of one of 16 parts, that Simpson's rule gives a sixth
    assert (np.abs(measured[1:] - forces[:-1]) <= np.maximum(jumps[:-1], jumps[1:]) / 6 / 16 * (1 + 1e-6)).all()
    assert np.ptp(forces) > 0.1 * forces[0]


def test_a_line_leaves_its_mean_over_each_step() -> None:
    """Steps of 1.6 and of 0.1 periods of mains hum: the sine's own mean over the step, beside that of the forces."""
    values: Values = {"line_disturbance.principal_force": 3.0, "line_disturbance.phase": 0.4}
    for step in (0.032, 0.002):
        times = np.arange(6) * step
        at = np.full(6, 0.15)
        hum, plain = (run("cycle", values, on, times, at, ("measured_principal_force",))[1:, 0] for on in (("line_disturbance",), ()))
        w = 2 * np.pi * 50
        np.testing.assert_allclose(hum - plain, -3 * np.diff(np.cos(w * times + 0.4)) / (w * step), atol=3e-5)


def test_outputs_are_the_means_and_hold() -> None:
    contact = Contact({"averaging": "cycle"})
    contact.start()
    begun = contact.get("principal_force")
    assert begun == contact.get("mean_principal_force") > 1
    contact.advance(1e-3)
    impulse = contact.get("principal_impulse")
    shown = contact.values()
    assert contact.get("principal_force") == pytest.approx(impulse / 1e-3, rel=1e-12)
    assert contact.get("principal_force") == pytest.approx(begun, rel=1e-9)  # nothing has changed
    assert contact.get("tool_force_x") == -contact.get("principal_force") == -contact.get("mean_principal_force")
    assert contact.get("tool_force_y") == contact.get("feed_force") == contact.get("measured_feed_force")
    assert 0 < contact.get("mean_contact_ratio") == contact.get("contact_rate") < 1
    assert contact.get("in_contact") == 1
    contact.set("cutting_speed", 0.4)
    contact.evaluate()
    contact.event()
    changed = {kernel.variables()[n].name for n in np.flatnonzero(contact.values() != shown)}
    assert changed == {"cutting_speed"}


@pytest.mark.parametrize("delta", [-1.2, 0.6])
def test_other_outputs_show_the_highest_place_of_an_ellipse_that_an_effect_has_tilted(delta: float) -> None:
    """There the tool does not move across the surface, and the slip is the speed along it times tan(phi); a tilted ellipse in the phase
    itself shows the same."""
    tilted = {"averaging": "cycle", "friction_law": "coulomb", "phase_x": -np.pi / 2}
    contact = Contact({**tilted, "phase_y": np.pi, "ellipse_phase_error.delta": delta}, ["ellipse_phase_error"])
    stated = Contact({**tilted, "phase_y": np.pi + delta})
    for each in (contact, stated):
        each.start()
        each.advance(1e-3)
    along = contact.get("cutting_speed") - contact.get("amplitude_x") * 2 * np.pi * FREQUENCY * np.sin(-np.pi - delta - np.pi / 2)
    assert contact.get("slip_velocity_used") == pytest.approx(along * np.tan(contact.get("chip_flow_shear_angle")), rel=1e-9)
    for name in ("slip_velocity_used", "mean_principal_force", "averaging_error"):
        assert contact.get(name) == pytest.approx(stated.get(name), rel=1e-9)


def test_a_window_of_its_own_collects_steps() -> None:
    """Windows of 2.5 ms over steps of 1 ms: means over the last full one, by integrals that rise straight within a step."""
    contact = Contact({"averaging": "cycle", "averaging_window": 2.5e-3})
    contact.start()
    forces, shown = [], []
    for value in np.linspace(0.1, 0.3, 10):
        contact.set("cutting_speed", float(value))
        contact.advance(1e-3)
        forces.append(contact.get("principal_force"))
        shown.append(contact.get("mean_principal_force"))
    first = (forces[0] + forces[1] + 0.5 * forces[2]) / 2.5
    second = (0.5 * forces[2] + forces[3] + forces[4]) / 2.5
    assert shown[1:9] == pytest.approx([0, *[first] * 2, *[second] * 3, shown[7], shown[8]], rel=1e-12)
    assert shown[9] > shown[7] > second > first


def test_a_copy_in_mid_run_goes_on_alike() -> None:
    values: Values = {"averaging": "cycle", "sensor_delay.time": 2e-4, "release_time": 1e-4}
    contact = Contact(values, ("sensor_delay", "sensor_lowpass", "holder_compliance", "regenerative"))
    contact.start()
    contact.advance(1e-3)
    twin = contact.copy()
    for one in (contact, twin):
        one.set("cutting_speed", 0.3)
        one.advance(1e-3)
        one.advance(3e-4)
    assert contact.state() == twin.state()


def test_the_derivative_is_that_of_the_means() -> None:
    """Against two contacts at other speeds: the chord of 2 %, to the curvature over it."""
    contact = Contact({"averaging": "cycle", "cutting_speed": 0.2})
    contact.start()
    slope = contact.derivative("feed_force", "cutting_speed")
    sides = []
    for value in (0.198, 0.202):
        other = Contact({"averaging": "cycle", "cutting_speed": value})
        other.start()
        sides.append(other.get("feed_force"))
    assert slope == pytest.approx((sides[1] - sides[0]) / 0.004, rel=0.02)


def test_what_has_no_cycle_is_refused() -> None:
    contact = Contact({"averaging": "cycle", "kinematics": "external"})
    with pytest.raises(SimulationError, match="averaging = resolved"):
        contact.start()


def test_a_step_that_fails_leaves_the_contact_where_it_was() -> None:
    """A law that leaves the room of finite numbers cannot be had; a step that is not one can."""
    contact = Contact({"averaging": "cycle"})
    contact.start()
    before = contact.state()
    for step in (0.0, -1e-3, float("nan"), float("inf")):
        with pytest.raises(SimulationError, match="not a number above 0"):
            contact.advance(step)
    assert contact.state() == before


@pytest.mark.parametrize("release", [0.0, 1e-6])
def test_wear_counts_the_way_of_the_cycles_that_are_not_run(release: float) -> None:
    """The cycle in the middle of a step begins with the way slid until then, and a second one (bristles that outlive theirs) again: the
    error of the means falls with the square of the step. A step of 1 ms is a third of the way to two thirds of the wear."""
    values: Values = {
        "vibration_frequency": 1e6,
        "amplitude_x": 1e-7,
        "amplitude_y": 1e-7,
        "relative_tolerance": 1e-7,
        "release_time": release,
    }
    values = {**values, "friction_wear.s_0": 1e-3, "friction_wear.delta": 0.5, "initial_state": "periodic"}
    fine = np.linspace(0, 0.008, 129)
    truth = run("resolved", values, ("friction_wear",), fine, np.full(fine.size, 0.3), (*IMPULSES, "sliding_distance"))
    assert truth[-1, 3] > 1.2e-3
    errors, counts = [], (4, 8, 16)
    for count in counts:
        times = np.linspace(0, 0.008, count + 1)
        rows = run("cycle", values, ("friction_wear",), times, np.full(count + 1, 0.3), (*IMPULSES, "sliding_distance"))
        assert rows[:, 3] == pytest.approx(truth[:: 128 // count, 3], rel=1e-4)
        exact = np.diff(truth[:: 128 // count, :3], axis=0) / np.diff(times)[:, None]
        errors.append(np.abs(np.diff(rows[:, :3], axis=0) / np.diff(times)[:, None] - exact).max())
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx([2, 2], abs=0.25)


@pytest.mark.parametrize("averaging", ["resolved", "cycle"])
def test_what_was_summed_up_before_the_start_is_not_of_the_first_window(averaging: str) -> None:
    means = []
    for before in (0.0, 3.0):
        contact = Contact({"averaging": averaging, "averaging_window": 2 * PERIOD})
        contact.set("principal_impulse", before)
        contact.start()
        contact.advance(2 * PERIOD)
        assert contact.get("principal_impulse") == pytest.approx(before, abs=0.1)
        means.append(contact.get("mean_principal_force"))
    assert means[1] == pytest.approx(means[0], rel=1e-6)
    assert means[0] > 1


@pytest.mark.parametrize("frequency", [15877.667222589067, 20000.0, 12345.678, 7e3])
def test_a_window_ends_with_a_step_that_ends_beside_it_by_roundings(frequency: float) -> None:
    """200 steps to a cycle: a step that ended a last digit before the window left the mean of the window before, or 0 N."""
    step, whole = 1 / (200 * frequency), Contact({"vibration_frequency": frequency})
    contact = Contact({"vibration_frequency": frequency})
    whole.start()
    contact.start()
    for cycle in range(1, 41):
        load = 1 + 0.1 * cycle  # each cycle has a mean of its own
        for each in (whole, contact):
            each.set("width", 1e-4 * load)
        whole.advance(1 / frequency)
        for _ in range(200):
            contact.advance(step)
        assert contact.get("mean_principal_force") == pytest.approx(whole.get("mean_principal_force"), rel=1e-4)


@pytest.mark.parametrize("law", ["coulomb", "lugre", "dahl", "reset_integrator"])
@pytest.mark.parametrize(("ratios", "steps"), [((1.2, 0.8), 25), ((0.8, 1.2), 25), ((1.2, 0.8), 7)])
def test_a_tool_that_begins_to_leave_the_chip_is_in_the_error(law: str, ratios: tuple[float, float], steps: int) -> None:
    """Forces have a kink there that the middle of a step does not show: 135 times what was said."""
    times = 8 * PERIOD * np.arange(steps + 1)
    at = np.linspace(*ratios, steps + 1) * 2 * np.pi * 20e3 * 5e-6
    values = {"friction_law": law, "initial_state": "periodic"}
    resolved, averaged = (means(averaging, values, (), times, at) for averaging in ("resolved", "cycle"))
    said = run("cycle", values, (), times, at, ("averaging_error",))[1:, 0]
    assert (np.abs(averaged - resolved).max(axis=1) <= FACTOR * said).all()
    assert said[0] < 0.5


@pytest.mark.parametrize("law", ["lugre", "dahl", "reset_integrator", "bristle"])
def test_bristles_that_start_as_set_are_in_the_error(law: str) -> None:
    """So they do with initial_state = steady, too, which settles what lags: 30 to 80 times what was said."""
    times = 20 * PERIOD * np.arange(4)
    values = {"friction_law": law, "initial_state": "steady"}
    at = np.full(4, 0.2)
    resolved, averaged = (means(averaging, values, (), times, at) for averaging in ("resolved", "cycle"))
    said = run("cycle", values, (), times, at, ("averaging_error",))[1:, 0]
    assert (np.abs(averaged - resolved).max(axis=1) <= FACTOR * said).all()
