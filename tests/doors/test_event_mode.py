"""Does the contact stop where it is gained and lost, hand the event over, and go on? Event mode, early return, intermediate update."""

from __future__ import annotations

import ctypes as ct
import math
from collections.abc import Callable
from pathlib import Path

import pytest
from raw_fmi import ERROR, OK, Door, Instance
from scipy.optimize import brentq

# Closed forms for the ellipse with a phase difference of 90 degrees, bottom at t = 0, where the nominal surface does not bind:
# in contact from -theta_s with HSR (pi - theta_s) = sin(theta_s) to theta_e = acos(-HSR).
FREQUENCY = 20e3
PERIOD = 1 / FREQUENCY
HSR = (10 / 60) / (2 * math.pi * FREQUENCY * 5e-6)
THETA_S = float(brentq(lambda theta: HSR * (math.pi - theta) - math.sin(theta), 1e-3, 2.0, xtol=1e-15))
THETA_E = math.acos(-HSR)
ENTRY, EXIT = PERIOD * (1 - THETA_S / (2 * math.pi)), PERIOD * THETA_E / (2 * math.pi)
# An event is located to a thousandth of relative_tolerance = 1e-4, of an internal step that is at most a twentieth of a period.
CLOSE = 1e-7 * PERIOD / 20

Make = Callable[..., Instance]


@pytest.fixture(scope="module")
def door(fmi3_fmu: Path, tmp_path_factory: pytest.TempPathFactory) -> Door:
    return Door(fmi3_fmu, tmp_path_factory.mktemp("door"))


def converge(one: Instance) -> None:
    """Go through the event mode that the instance is in."""
    status, _, next_event = one.update()
    assert (status, next_event) == (OK, None)  # within a step the contact closes its averaging windows itself
    assert one.call("EnterStepMode") == OK


def follow(one: Instance, end: float) -> list[tuple[float, float]]:
    """One long step to `end`, as often as events ask for: (time, in_contact after the event)."""
    time, events = one.get("time")[0], []
    while time < end - CLOSE:
        status, event, early, time = one.step3(time, end - time)
        assert status == OK, one.lines
        assert event == early
        assert one.get("time") == [time]
        if event:
            assert one.call("EnterEventMode") == OK
            converge(one)
            events.append((time, one.get("in_contact")[0]))
    return events


def test_a_step_ends_where_contact_is_gained_or_lost(make: Make) -> None:
    one = make(event_mode=True, early_return=True)
    converge(one.start())
    assert one.get("in_contact") == [1.0]
    events = follow(one, 2.9 * PERIOD)
    before = [1.0, *(contact for _, contact in events)]
    changes = [event for event, old in zip(events, before, strict=False) if event[1] != old]
    expected = [(EXIT, 0.0), (ENTRY, 1.0), (EXIT + PERIOD, 0.0), (ENTRY + PERIOD, 1.0), (EXIT + 2 * PERIOD, 0.0), (ENTRY + 2 * PERIOD, 1.0)]
    assert [contact for _, contact in changes] == [contact for _, contact in expected]
    for (time, _), (due, _) in zip(changes, expected, strict=True):
        assert abs(time - due) <= CLOSE
    assert len(events) < 20  # and reversals of friction, but no storm


def test_stopping_at_events_or_going_through_them_is_one_run(make: Make) -> None:
    names = "bristle_deflection", "dissipated_energy", "principal_force", "mean_feed_force", "mean_contact_ratio"
    values = {"relative_tolerance": 1e-9}
    stopping, going = make(event_mode=True, early_return=True), make()
    converge(stopping.start(values))
    going.start(values)
    assert follow(stopping, 3.3 * PERIOD)
    assert going.step(0.0, 3.3 * PERIOD) == OK
    # other internal steps, both good to their tolerance of 1e-9; the sum of their errors is below 1e-7
    assert stopping.get(*names) == pytest.approx(going.get(*names), rel=1e-7)
    assert going.get("mean_contact_ratio")[0] == pytest.approx((THETA_S + THETA_E) / (2 * math.pi), rel=1e-6)


def test_without_early_return_a_step_goes_through_its_events(make: Make) -> None:
    one = make(event_mode=True, early_return=False)
    converge(one.start())
    assert one.step3(0.0, 3 * PERIOD) == (OK, False, False, 3 * PERIOD)


def test_an_event_has_to_be_handled(make: Make) -> None:
    one = make(event_mode=True, early_return=True)
    converge(one.start())
    status, event, _, time = one.step3(0.0, PERIOD)
    assert (status, event) == (OK, True)
    assert one.step(time, 1e-6) == ERROR
    assert "Event Mode" in one.said()
    assert one.call("Reset") == OK
    converge(one.start())
    assert one.step3(0.0, PERIOD)[1]
    assert one.call("EnterEventMode") == OK
    assert one.call("EnterStepMode") == ERROR
    assert "fmi3UpdateDiscreteStates" in one.said()


def test_event_mode_is_for_hosts_that_have_asked_for_it(make: Make) -> None:
    one = make()
    one.start()
    assert one.call("EnterEventMode") == ERROR
    assert "eventModeUsed" in one.said()
    two = make(event_mode=True)
    two.start()
    assert two.step(0.0, 1e-6) == ERROR  # after initialisation comes event mode
    assert "Event Mode" in two.said()


def test_with_event_mode_parameters_change_at_events_only(make: Make) -> None:
    one = make(event_mode=True)
    one.start()
    assert one.set({"F_C": 8.0}) == OK
    converge(one)
    assert one.set({"slip_velocity": 0.0, "cutting_speed": 0.1}) == OK
    assert one.set({"F_C": 7.0}) == ERROR
    assert "Event Mode" in one.said()


def test_intermediate_update_shows_every_event_and_the_end(make: Make) -> None:
    seen: list[tuple[float, float]] = []

    def look(one: Instance, time: float) -> None:
        seen.append((time, one.get("in_contact")[0]))
        assert one.get("time") == [time]

    one = make(update=look)
    one.start()
    assert one.step3(0.0, 1.9 * PERIOD)[:3] == (OK, False, False)
    times = [time for time, _ in seen]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(1.9 * PERIOD, rel=1e-15)
    for due, contact in ((EXIT, 0.0), (ENTRY, 1.0), (EXIT + PERIOD, 0.0), (ENTRY + PERIOD, 1.0)):
        assert [after for time, after in seen if abs(time - due) <= CLOSE] == [contact]


def test_the_host_may_end_a_step_from_an_intermediate_update(make: Make) -> None:
    asked = EXIT + 0.1 * PERIOD

    def look(one: Instance, time: float) -> float | None:
        return asked if abs(time - EXIT) <= CLOSE else None

    one = make(update=look, early_return=True)
    one.start()
    status, event, early, time = one.step3(0.0, 2 * PERIOD)
    assert (status, event, early) == (OK, False, True)
    assert time == pytest.approx(asked, rel=1e-12)
    assert one.step3(time, 2 * PERIOD - time)[:3] == (OK, False, False)
    deaf = make(update=look)  # a host that cannot take an early return does not get one
    deaf.start()
    assert deaf.step3(0.0, 2 * PERIOD)[:3] == (OK, False, False)


@pytest.mark.parametrize(
    ("step", "values", "said"),
    [(1e-6, {"cutting_speed": 0.1}, "Intermediate Update Mode before the end of a step"), (PERIOD, {"F_C": 7.0}, "F_C")],
)
def test_an_intermediate_update_takes_no_parameter_and_nothing_at_the_end(
    make: Make, step: float, values: dict[str, float], said: str
) -> None:
    answers: list[int] = []
    one = make(update=lambda instance, _time: answers.append(instance.set(values)))
    one.start()
    assert one.step(0.0, step) == ERROR
    assert answers == [ERROR]
    assert said in one.said()
    assert one.call("Reset") == OK


def test_inputs_that_are_given_at_every_event_follow_a_ramp_better_than_held_ones(make: Make, fmi2_fmu: Path, tmp_path: Path) -> None:
    """A step of 1 ms in which the cutting speed rises from 0.1 to 0.3 m/s. Against FMI 2 with the derivative of the input, where it rises
    straight: events come several times a cycle of 20, so nine tenths of the error of the held input go, and more."""

    def rising(time: float) -> float:
        return 0.1 + 200.0 * time

    def follow(one: Instance, time: float) -> None:
        if time < 1e-3 * (1 - 1e-9):
            assert one.set({"cutting_speed": rising(time)}) == OK

    truth = Instance(Door(fmi2_fmu, tmp_path))
    held, followed = make(), make(update=follow)
    for one in (truth, held, followed):
        one.start({"cutting_speed": rising(0.0)})
    reference = (ct.c_uint * 1)(truth.door.reference["cutting_speed"])
    assert truth.call("SetRealInputDerivatives", reference, 1, (ct.c_int * 1)(1), (ct.c_double * 1)(200.0)) == OK
    impulses = [(one.step(0.0, 1e-3), one.get("principal_impulse")[0]) for one in (truth, held, followed)]
    truth.free()
    assert [status for status, _ in impulses] == [OK] * 3
    true, of_held, of_followed = (impulse for _, impulse in impulses)
    assert abs(of_followed - true) < 0.1 * abs(of_held - true)
    assert abs(of_held - true) > 0.1 * true


def test_configuration_and_dependencies(make: Make) -> None:
    one = make()
    assert one.call("EnterConfigurationMode") == OK
    assert one.set({"F_C": 8.0}) == ERROR  # no structural parameters, so nothing can be set
    assert "Configuration Mode" in one.said()
    assert one.call("Reset") == OK
    assert one.call("EnterConfigurationMode") == OK
    assert one.call("ExitConfigurationMode") == OK
    one.start()
    assert one.call("EvaluateDiscreteStates") == ERROR  # only in event mode
    one.lines.clear()
    assert one.call("Reset") == OK
    assert one.call("GetNumberOfVariableDependencies", 1, ct.byref(ct.c_size_t())) == ERROR
    assert "modelDescription.xml" in one.said()
    assert one.call("Reset") == OK
    assert one.call("ActivateModelPartition", 1, 0.0) == ERROR
    assert "Scheduled Execution" in one.said()
