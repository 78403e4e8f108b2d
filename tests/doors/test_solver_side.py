"""Does the instance serve a solver outside? States, rates, indicators, time events of model exchange; derivatives of both interfaces."""

from __future__ import annotations

import ctypes as ct
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from evat.native import kernel
from raw_fmi import ERROR, OK, Door, EventInfo2, Instance

STATES = len(kernel.states())
PERIOD = 5e-5  # [s]


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    fmu: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return Door(fmu, tmp_path_factory.mktemp("door"))


@pytest.fixture
def one(door: Door) -> Iterator[Instance]:
    instance = Instance(door, model_exchange=True)
    yield instance
    instance.free()


def vector(one: Instance, name: str, count: int = STATES) -> list[float]:
    """A vector that the instance fills."""
    name = name if one.door.version == 3 else name.replace("ContinuousStateDerivatives", "Derivatives")
    numbers = (ct.c_double * count)()
    assert one.call(name, numbers, ct.c_size_t(count)) == OK, one.lines
    return list(numbers)


def set_states(one: Instance, states: list[float]) -> int:
    return one.call("SetContinuousStates", (ct.c_double * len(states))(*states), ct.c_size_t(len(states)))


def integrating(one: Instance, values: dict[str, float]) -> Instance:
    one.start(values)
    assert one.update()[0] == OK
    assert one.call("EnterContinuousTimeMode") == OK
    return one


@pytest.mark.parametrize("name", ["GetContinuousStateDerivatives", "GetEventIndicators", "GetContinuousStates"])
def test_nothing_is_shown_to_a_solver_before_initialisation(one: Instance, name: str) -> None:
    """What has not been set up has no rates; in Initialization Mode it has."""
    count = len(kernel.states()) if name != "GetEventIndicators" else 4
    own = name if one.door.version == 3 else name.replace("ContinuousStateDerivatives", "Derivatives")
    assert one.call(own, (ct.c_double * count)(), ct.c_size_t(count)) == ERROR
    assert "Instantiated" in one.said()
    assert one.call("Reset") == OK
    assert one.set_up() == OK
    vector(one, name, count)


def test_rates_are_the_equations(one: Instance) -> None:
    """LuGre: dz/dt = v at z = 0 and 0 at z = g/sigma0; impulses grow by the forces, energies by F v and the power of shearing; what is
    off stands still."""
    integrating(one, {"kinematics": 2, "slip_velocity": 0.5})
    rates = vector(one, "GetContinuousStateDerivatives")
    force, principal, feed, normal, shear = one.get("friction_force", "principal_force", "feed_force", "normal_force", "shear_power")
    first = [0.5, 0.5, force * 0.5, shear, force, principal, feed, normal, 1.0, force, principal, feed]
    assert rates == pytest.approx(first + [0.0] * (STATES - len(first)), rel=1e-12)
    steady = [9e-6, *(float(n) for n in range(1, STATES))]  # 0.5 m/s is far above v_s: g = F_C
    assert set_states(one, steady) == OK
    assert vector(one, "GetContinuousStates") == steady
    assert abs(vector(one, "GetContinuousStateDerivatives")[0]) <= 1e-12
    assert one.get("bristle_deflection") == [9e-6]
    assert one.get("friction_force") == pytest.approx([9.5], rel=1e-12)


def test_integrals_are_led_since_the_last_event(one: Instance) -> None:
    """What a solver leads is counted anew at each event and does not grow; what is shown beside it goes on from the start."""
    integrating(one, {"kinematics": 2, "slip_velocity": 0.5, "averaging_window": 1e-3})
    names, sums = [*kernel.states()[2:12]], [name.removeprefix("recent_") for name in kernel.states()[2:12]]
    assert all(name.startswith("recent_") for name in names)
    first = [1e-6, 2e-4, *(n * 1e-5 for n in range(1, 11)), *[0.0] * (STATES - 12)]
    assert set_states(one, first) == OK
    assert one.get(*names) == one.get(*sums) == first[2:12]
    assert one.call("SetTime", 1e-3) == OK
    assert one.call("EnterEventMode") == OK
    status, changed, next_event = one.update()
    assert (status, changed, next_event) == (OK, True, pytest.approx(2e-3, rel=1e-12))
    assert one.get(*names) == [0.0] * 10
    assert one.get(*sums) == first[2:12]
    assert vector(one, "GetContinuousStates") == [*first[:2], *[0.0] * (STATES - 2)]
    assert one.get("mean_principal_force") == pytest.approx([first[5] / 1e-3], rel=1e-12)
    assert one.call("EnterContinuousTimeMode") == OK
    second = [*first[:2], *(n * 3e-7 for n in range(1, 11)), *first[12:]]
    assert set_states(one, second) == OK
    assert one.get(*sums) == [a + b for a, b in zip(first[2:12], second[2:12], strict=True)]
    assert vector(one, "GetContinuousStates") == second  # to the last bit


def test_nominals_are_above_0(one: Instance) -> None:
    assert all(nominal > 0 for nominal in vector(one, "GetNominalsOfContinuousStates"))


def nominals_change(one: Instance) -> bool:
    """What an event says of it."""
    if one.door.version == 2:
        info = EventInfo2()
        assert one.call("NewDiscreteStates", ct.byref(info)) == OK
        return bool(info.nominals_changed)
    flags, moment = [ct.c_bool() for _ in range(5)], ct.c_double()
    assert one.call("UpdateDiscreteStates", *map(ct.byref, flags), ct.byref(moment)) == OK
    return bool(flags[2].value)


def test_the_nominal_of_a_stiff_bristle_is_what_bends_it(one: Instance) -> None:
    """A solver weighs a state by its nominal where that is larger: a micrometre would hide a deflection of some nanometres. A parameter
    may change it at an event, which says so once."""
    usual = kernel.variable("bristle_deflection").nominal
    integrating(one, {"F_C": 0.5, "F_S": 0.6, "sigma0": 1e7})
    nominals = vector(one, "GetNominalsOfContinuousStates")
    assert nominals == [pytest.approx(6e-8, rel=1e-12), *(kernel.variable(name).nominal for name in kernel.states()[1:])]
    assert one.call("EnterEventMode") == OK
    assert not nominals_change(one)
    assert one.set({"sigma0": 1e5}) == OK
    assert nominals_change(one)
    assert not nominals_change(one)
    assert vector(one, "GetNominalsOfContinuousStates") == [usual, *nominals[1:]]
    state = one.save()
    assert one.set({"sigma0": 1e7}) == OK
    assert nominals_change(one)
    assert one.restore(state) == OK
    assert nominals_change(one)
    assert vector(one, "GetNominalsOfContinuousStates") == [usual, *nominals[1:]]
    assert one.restore(state) == OK
    assert not nominals_change(one)
    assert one.drop(state) == OK


def test_indicators_change_sign_with_contact(one: Instance) -> None:
    integrating(one, {})
    first = vector(one, "GetEventIndicators", 4)
    assert one.call("SetTime", 0.5 * PERIOD) == OK  # the tool is at the top of its path, far out of the material
    later = vector(one, "GetEventIndicators", 4)
    assert first[0] > 0 > later[0]
    assert one.get("in_contact") == [1.0]  # held until the event
    assert one.call("EnterEventMode") == OK
    status, states_changed, next_event = one.update()
    assert (status, states_changed) == (OK, True)  # the bristles were at rest already, and the rates have jumped
    assert one.update()[:2] == (OK, False)
    assert next_event == pytest.approx(PERIOD, rel=1e-12)  # the averaging window ends
    assert one.get("in_contact") == [0.0]
    assert one.get("friction_force") == [0.0]


def crossing(one: Instance, place: int, begin: float, end: float) -> tuple[float, float]:
    """The last two moments between which the indicator changes its sign, as a host finds them: by halving."""

    def side(time: float) -> bool:
        assert one.call("SetTime", time) == OK
        return vector(one, "GetEventIndicators", 4)[place] > 0

    low, high, before = begin, end, side(begin)
    assert side(end) != before
    while low < (middle := (low + high) / 2) < high:
        low, high = (middle, high) if side(middle) == before else (low, middle)
    return low, high


@pytest.mark.parametrize("behind", [0, 1], ids=["just before", "just behind"])
def test_every_event_says_that_rates_have_jumped_and_no_indicator_is_0_behind_it(one: Instance, behind: int) -> None:
    """Exit, entry, the surface that stands, reversal, as a host meets them that stops on either side of what it has found. Hosts restart
    their solver on valuesOfContinuousStatesChanged only; at entry no state has changed, and all rates have."""
    integrating(one, {"cutting_speed": 0.3 * 2 * math.pi * 5e-6 / PERIOD})
    time, met = 0.0, []
    while time < 2.2 * PERIOD:
        held = [x > 0 for x in vector(one, "GetEventIndicators", 4)]
        for n in range(1, 4000):
            later = time + n * PERIOD / 1000
            assert one.call("SetTime", later) == OK
            turned = [k for k, x in enumerate(vector(one, "GetEventIndicators", 4)) if (x > 0) != held[k]]
            if turned:
                break
        place = min(turned, key=lambda k: crossing(one, k, later - PERIOD / 1000, later))
        time = crossing(one, place, later - PERIOD / 1000, later)[behind]
        assert one.call("SetTime", time) == OK
        assert one.call("EnterEventMode") == OK
        states, rates = (vector(one, name) for name in ("GetContinuousStates", "GetContinuousStateDerivatives"))
        contact = one.get("in_contact")
        assert one.update()[:2] == (OK, True)
        indicators = vector(one, "GetEventIndicators", 4)
        assert min(map(abs, indicators)) > 0.99e-9, indicators
        assert (indicators[place] > 0) != held[place]
        if one.get("in_contact") > contact:  # entry
            assert vector(one, "GetContinuousStates") == states
            assert vector(one, "GetContinuousStateDerivatives") != rates
        assert one.update()[:2] == (OK, False)
        assert one.call("EnterContinuousTimeMode") == OK
        met.append((place, one.get("in_contact")[0]))
    # from the bottom: friction turns round, exit; the tool comes in again on what the cycle before left, up to the nominal surface
    assert [place for place, _ in met[:2]] == [2, 0]
    assert [side for place, side in met if place == 0] == [0, 1, 0, 1, 0]
    assert {place for place, _ in met} >= {0, 1, 2}


def test_indicators_are_of_order_1(one: Instance) -> None:
    """Of a guideway that creeps under a chip of 50 um, at 1 mm/s: as a solver weighs them."""
    integrating(one, {"kinematics": 2, "slip_velocity": 1e-3, "uncut_thickness": 5e-5, "friction_law": 6})
    contact, surface, slip, law = vector(one, "GetEventIndicators", 4)
    assert contact == pytest.approx(50.0, rel=1e-9)
    assert (surface, slip, law) == pytest.approx((1.0, 1.0, 1.0), rel=1e-7)
    if one.door.version == 3:  # there they are variables
        assert one.get(*kernel.indicators()) == [contact, surface, slip, law]


def test_bristles_that_lose_contact_are_let_go_at_the_event(one: Instance) -> None:
    integrating(one, {})
    assert set_states(one, [5e-6] + [0.0] * (STATES - 1)) == OK
    assert one.call("SetTime", 0.5 * PERIOD) == OK
    assert one.call("EnterEventMode") == OK
    assert one.update()[:2] == (OK, True)
    assert vector(one, "GetContinuousStates")[0] == 0.0
    assert one.update()[:2] == (OK, False)  # once is enough


def test_euler_by_hand_comes_to_the_same_steady_force(one: Instance) -> None:
    """500 explicit steps well below the time constant F_C/(sigma0 v) = 18 us lead to F = F_C + sigma2 v."""
    integrating(one, {"kinematics": 2, "slip_velocity": 0.5})
    states, size = vector(one, "GetContinuousStates"), 1e-6
    flags = ct.c_int(7), ct.c_int(7)
    for n in range(500):
        rates = vector(one, "GetContinuousStateDerivatives")
        states = [x + size * rate for x, rate in zip(states, rates, strict=True)]
        assert one.call("SetTime", (n + 1) * size) == OK
        assert set_states(one, states) == OK
        assert one.call("CompletedIntegratorStep", 1, *map(ct.byref, flags)) == OK
    assert [flag.value & 1 for flag in flags] == [0, 0]
    assert one.get("friction_force") == pytest.approx([9.5], rel=1e-9)


def test_wrong_vectors_are_refused(one: Instance) -> None:
    integrating(one, {})
    before = vector(one, "GetContinuousStates")
    for states, words in (
        ([0.0] * 6, "array of 6"),
        ([math.nan] + [0.0] * (STATES - 1), "bristle_deflection is nan"),
        ([0.0] * (STATES - 1) + [math.inf], "inf"),
    ):
        assert set_states(one, states) == ERROR
        assert words in one.said()
        assert vector(one, "GetContinuousStates") == before
        assert one.call("Reset") == OK
        integrating(one, {})
    assert one.call("SetTime", math.nan) == ERROR
    assert "time" in one.said()
    assert one.call("Reset") == OK
    integrating(one, {})
    assert one.step(0.0, 1e-6) == ERROR  # a step is not for model exchange
    assert "Continuous-Time Mode" in one.said()


def test_counts_of_fmi3(fmi3_fmu: Path, tmp_path: Path) -> None:
    door, count = Door(fmi3_fmu, tmp_path), ct.c_size_t()
    one, stepper = Instance(door, model_exchange=True), Instance(door)
    assert one.call("GetNumberOfContinuousStates", ct.byref(count)) == OK
    assert count.value == STATES
    assert one.call("GetNumberOfEventIndicators", ct.byref(count)) == OK
    assert count.value == 4
    assert stepper.call("GetNumberOfContinuousStates", ct.byref(count)) == ERROR
    assert "Model Exchange" in stepper.said()
    one.free()
    stepper.free()


Asked = list[str] | list[int]


def derivative(one: Instance, unknowns: Asked, knowns: Asked, seed: list[float], adjoint: bool = False) -> tuple[int, list[float]]:
    """Of names, or of value references that have none."""
    of, three = one.door.reference, one.door.version == 3
    places = [[name if isinstance(name, int) else of[name] for name in names] for names in (unknowns, knowns)]
    references = [(ct.c_uint * len(some))(*some) for some in places]
    result = (ct.c_double * len(knowns if adjoint else unknowns))()
    tail = [
        (ct.c_double * len(seed))(*seed),
        *([ct.c_size_t(len(seed))] if three else []),
        result,
        *([ct.c_size_t(len(result))] if three else []),
    ]
    name = "GetAdjointDerivative" if adjoint else "GetDirectionalDerivative"
    status = one.call(name, references[0], ct.c_size_t(len(unknowns)), references[1], ct.c_size_t(len(knowns)), *tail)
    return status, list(result)


def test_directional_derivatives_are_those_of_the_law(one: Instance) -> None:
    """At rest a bristle is a spring and a damper: dF/dz = sigma0, dF/dv = sigma1 + sigma2, d(dz/dt)/dv = 1."""
    integrating(one, {"kinematics": 2, "slip_velocity": 0.0, "bristle_deflection": 1e-6, "sigma1": 3.0})
    status, columns = derivative(one, ["friction_force", "bristle_rate", "bristle_deflection"], ["bristle_deflection"], [1.0])
    assert status == OK
    assert columns == pytest.approx([1e6, 0.0, 1.0], rel=1e-6, abs=1e-6)
    # 1 m/s is a long way from rest: differences of v near 0 meet the kink of |v|, which weighs z/g sigma0 = 1/9 or 1/10
    status, (force, rate) = derivative(one, ["friction_force", "bristle_rate"], ["slip_velocity"], [1.0])
    assert status == OK
    assert force == pytest.approx(3.0 + 1.0, rel=0.11)
    assert rate == pytest.approx(1.0, rel=0.11)
    assert derivative(one, ["friction_force"], ["bristle_deflection", "slip_velocity"], [2e-6, 0.0])[1] == pytest.approx([2.0], rel=1e-6)


def test_a_column_of_the_jacobian_costs_as_much_as_an_entry(one: Instance) -> None:
    """All unknowns are seen at once. One by one a column took as long as all its entries, and a solver was slower by it than without."""
    integrating(one, {})
    rates = [v.name for v in kernel.variables() if v.derivative_of]
    knowns = ["bristle_deflection"]

    def seconds(unknowns: list[str]) -> float:
        begun = time.process_time()
        for _ in range(50):
            assert derivative(one, unknowns, knowns, [1.0])[0] == OK
        return time.process_time() - begun

    assert min(seconds(rates) for _ in range(5)) < 4 * min(seconds(rates[:1]) for _ in range(5))
    _, column = derivative(one, rates, knowns, [1.0])
    assert column == [derivative(one, [rate], knowns, [1.0])[1][0] for rate in rates]


def test_adjoint_and_directional_derivative_are_one_matrix(fmi3_fmu: Path, tmp_path: Path) -> None:
    one = Instance(Door(fmi3_fmu, tmp_path))
    one.start({"kinematics": 2, "slip_velocity": 0.05, "thermal_softening": 1, "bristle_deflection": 3e-6})
    unknowns, knowns = ["friction_force", "principal_force", "bristle_rate"], ["slip_velocity", "uncut_thickness", "bristle_deflection"]
    luck = np.random.default_rng(1)
    x, y = luck.normal(size=3) * [1e-2, 1e-5, 1e-6], luck.normal(size=3)
    forward, backward = derivative(one, unknowns, knowns, list(x)), derivative(one, unknowns, knowns, list(y), adjoint=True)
    assert (forward[0], backward[0]) == (OK, OK)
    assert np.dot(y, forward[1]) == pytest.approx(np.dot(backward[1], x), rel=1e-12)
    assert np.linalg.norm(forward[1]) > 0.1
    one.free()


def test_derivatives_of_the_first_reference_that_is_none_are_refused(one: Instance) -> None:
    """One behind the last variable, where a table ends."""
    integrating(one, {})
    behind = max(one.door.reference.values()) + 1
    for unknowns, knowns in (([behind], ["slip_velocity"]), (["friction_force"], [behind])):
        assert derivative(one, unknowns, knowns, [1.0])[0] == ERROR
        assert f"value reference {behind} is no" in one.said()
        assert one.call("Reset") == OK
        integrating(one, {})


def test_derivatives_of_what_has_none_are_refused(one: Instance) -> None:
    integrating(one, {})
    for unknowns, knowns, words in (
        (["in_contact"], ["slip_velocity"], "in_contact is no unknown"),
        (["slip_velocity"], ["slip_velocity"], "slip_velocity is no unknown"),
        (["friction_force"], ["F_C"], "F_C is no known"),
    ):
        assert derivative(one, unknowns, knowns, [1.0])[0] == ERROR
        assert words in one.said()
        assert one.call("Reset") == OK
        integrating(one, {})
