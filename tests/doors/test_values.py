"""What may be set when, and what does a wrong value do? Nothing, but for one line that says what was wrong."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Iterator
from pathlib import Path

import pytest
from raw_fmi import BOOLEAN, CHOICE, ERROR, INTEGER, OK, REAL, Door, Instance


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI2", "FMI3"])
def door(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Door:
    fmu: Path = request.getfixturevalue(f"fmi{request.param}_fmu")
    return Door(fmu, tmp_path_factory.mktemp("door"))


@pytest.fixture
def one(door: Door) -> Iterator[Instance]:
    instance = Instance(door)
    yield instance
    instance.free()


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("F_C", float("nan"), ["F_C", " N", "finite", "9 N is kept"]),
        ("F_C", float("inf"), ["F_C", "finite"]),
        ("F_C", -1.0, ["F_C = -1 N", "1e-06 to 1e+06 N", "9 N is kept"]),
        ("v_s", 1e3, ["v_s = 1000 m/s", "1e-07 to 100 m/s"]),
        ("slip_velocity", float("-inf"), ["slip_velocity", "finite"]),
        ("slip_velocity", 2e3, ["slip_velocity = 2000 m/s", "-1000 to 1000"]),
        ("friction_law", 0, ["friction_law = 0", "1 to 7"]),
        ("friction_law", 8, ["friction_law = 8", "1 to 7"]),
        ("damping_margin", 1.0, ["damping_margin = 1 ", "0.001 to 0.999"]),
    ],
)
def test_a_value_out_of_bounds_is_refused_and_the_old_one_kept(one: Instance, name: str, value: float, words: list[str]) -> None:
    (before,) = one.get(name)
    assert one.set({name: value}) == ERROR
    line = one.said()
    assert all(word in line for word in words), line
    assert one.get(name) == [before]
    assert one.call("Reset") == OK
    one.start()
    assert one.step(0.0, 1e-6) == OK


def test_of_an_array_with_one_wrong_value_nothing_is_set(one: Instance) -> None:
    assert one.set({"F_C": 5.0, "F_S": 6.0, "v_s": -1.0}) == ERROR
    assert "v_s" in one.said()
    assert one.get("F_C", "F_S", "v_s") == [9.0, 10.0, 0.01]


def test_an_unknown_reference_or_another_type_is_refused(one: Instance) -> None:
    of, count = one.door.reference, len(one.door.reference)
    for kind, reference in ((REAL, 0), (REAL, count + 1), (REAL, 2**32 - 1), (INTEGER, count + 1), (BOOLEAN, 0)):
        assert one.set_as(kind, [reference], [1]) == ERROR
        line = one.said()
        assert f"value reference {reference}" in line
        assert f"1 to {count}" in line
        assert one.call("Reset") == OK
        assert one.get_as(kind, [reference])[0] == ERROR
        one.lines.clear()
        assert one.call("Reset") == OK
    wrong = [
        (REAL, "friction_law"),
        (REAL, "step_count"),
        (INTEGER, "F_C"),
        (BOOLEAN, "F_C"),
        (CHOICE, "in_contact"),
        (INTEGER, "thermal_damping"),
    ]
    for kind, name in wrong:
        assert one.get_as(kind, [of[name]])[0] == ERROR
        line = one.said()
        assert name in line
        assert "variables only" in line
        assert one.call("Reset") == OK


def test_missing_arrays_are_an_error_and_empty_ones_are_not(one: Instance) -> None:
    word = {2: "GetReal", 3: "GetFloat64"}[one.door.version]
    one_item, tail = ct.c_size_t(1), [] if one.door.version == 2 else [ct.c_size_t(1)]
    assert one.call(word, None, one_item, (ct.c_double * 1)(), *tail) == ERROR
    assert "NULL" in one.said()
    assert one.call("Reset") == OK
    assert one.call(word, (ct.c_uint * 1)(1), one_item, None, *tail) == ERROR
    assert "NULL" in one.said()
    assert one.call("Reset") == OK
    assert one.call(word, None, ct.c_size_t(0), None, *([] if one.door.version == 2 else [ct.c_size_t(0)])) == OK


def test_fixed_parameters_only_before_the_start_and_tunable_ones_also_later(one: Instance) -> None:
    one.start({"kinematics": 2, "slip_velocity": 0.5, "vibration_frequency": 1e4})
    assert one.step(0.0, 1e-3) == OK
    (before,) = one.get("friction_force")
    assert one.set({"F_C": 18.0, "F_S": 20.0}) == OK
    assert one.step(1e-3, 1e-3) == OK
    (after,) = one.get("friction_force")
    # steady slip far above v_s: the Coulomb force, and 0.5 N of viscous friction on top; 1e-4 is the tolerance of the steps
    assert before == pytest.approx(9.5, rel=1e-4)
    assert after == pytest.approx(18.5, rel=1e-4)
    assert one.set({"vibration_frequency": 2e4}) == ERROR
    line = one.said()
    assert "vibration_frequency" in line
    assert "fixed" in line
    assert one.get("vibration_frequency") == [1e4]


@pytest.mark.parametrize("name", ["friction_force", "mean_feed_force", "bristle_rate", "time"])
def test_results_and_time_are_not_set(one: Instance, name: str) -> None:
    assert one.set({name: 1.0}) == ERROR
    assert name in one.said()


def test_a_state_has_a_start_value_and_nothing_more(one: Instance) -> None:
    """At rest a bent bristle is a spring: sigma0 z, with sigma0 = 1e6 N/m at its start value."""
    assert one.set({"kinematics": 2, "uncut_thickness": 1e-4, "bristle_deflection": 4e-6}) == OK
    assert one.set_up() == OK
    assert one.get("friction_force") == pytest.approx([4.0], rel=1e-12)
    assert one.set({"bristle_deflection": 2e-6}) == OK
    assert one.get("friction_force", "bristle_deflection") == pytest.approx([2.0, 2e-6], rel=1e-12)
    assert one.call("ExitInitializationMode") == OK
    assert one.get("friction_force") == pytest.approx([2.0], rel=1e-12)
    assert one.set({"bristle_deflection": 1e-6}) == ERROR
    assert "bristle_deflection" in one.said()


def test_a_solver_may_lead_the_states_one_by_one(door: Door) -> None:
    """CasADi sets them by their value references, as Reference-FMUs let it. At rest a bent bristle is a spring."""
    one = Instance(door, model_exchange=True)
    one.start({"kinematics": 2, "uncut_thickness": 1e-4})
    for enter, deflection in ((None, 3e-6), ("EnterContinuousTimeMode", 2e-6)):
        assert enter is None or one.call(enter) == OK
        assert one.set({"bristle_deflection": deflection, "recent_friction_impulse": 7.0}) == OK
        led = ("friction_force", "bristle_deflection", "recent_friction_impulse", "friction_impulse")
        assert one.get(*led) == pytest.approx([1e6 * deflection, deflection, 7.0, 7.0])
    assert one.set({"friction_force": 1.0}) == ERROR
    one.free()


def test_outputs_follow_what_is_set(one: Instance) -> None:
    """Coulomb friction has no memory: the force turns with the input, before any step, and at its size."""
    one.start({"kinematics": 2, "friction_law": 1, "slip_velocity": 0.5})
    assert one.get("friction_force") == [9.0]
    assert one.set({"slip_velocity": -0.5}) == OK
    assert one.get("friction_force") == [-9.0]
    assert one.set({"F_C": 3.0}) == OK
    assert one.get("friction_force") == [-3.0]


def test_initialisation_mode_shows_the_start_and_does_not_make_it(one: Instance) -> None:
    """The periodic state is shown as often as it is asked for; that the start is at rest after all is still free to choose."""
    assert one.set({"initial_state": 2}) == OK
    assert one.set_up() == OK
    first = one.get("bristle_deflection", "friction_force", "in_contact")
    assert first[0] != 0
    assert one.get("bristle_deflection", "friction_force", "in_contact") == first
    assert one.set({"initial_state": 1}) == OK
    assert one.get("bristle_deflection") == [0.0]
    assert one.call("ExitInitializationMode") == OK
    assert one.get("bristle_deflection", "step_count") == [0.0, 0.0]


def test_an_item_of_an_enumeration_is_its_place_from_1(one: Instance) -> None:
    items = one.door.variables["friction_law"].declaredType.items
    assert [int(item.value) for item in items] == list(range(1, len(items) + 1))
    by_name = {item.name: int(item.value) for item in items}
    forces = {}
    for law in ("coulomb", "lugre"):
        one.start({"kinematics": 2, "friction_law": by_name[law], "slip_velocity": 0.5})
        forces[law] = one.get("friction_force")[0]
        assert one.get("friction_law") == [by_name[law]]
        assert one.call("Reset") == OK
    assert forces["coulomb"] == 9.0  # Coulomb's force is there at once,
    assert 0 < forces["lugre"] < 7  # a bristle that is not bent yet has only its damping


def test_boolean_switches(one: Instance) -> None:
    assert one.get("thermal_softening") == [0]
    assert one.set({"thermal_softening": 1}) == OK
    assert one.get("thermal_softening") == [1]
    reference = [one.door.reference["thermal_damping"]]
    word, item = ("SetBoolean", ct.c_int) if one.door.version == 2 else ("SetBoolean", ct.c_ubyte)
    tail = [] if one.door.version == 2 else [ct.c_size_t(1)]
    assert one.call(word, (ct.c_uint * 1)(*reference), ct.c_size_t(1), (item * 1)(77), *tail) == OK  # neither 0 nor 1
    assert one.get("thermal_damping") == [1]


def test_types_that_the_fmu_does_not_have(one: Instance) -> None:
    two = one.door.version == 2
    for word in ["String"] if two else ["Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "UInt64", "String"]:
        for verb in ("Get", "Set"):
            assert one.call(verb + word, None, ct.c_size_t(0), None, ct.c_size_t(0)) == OK
            assert one.call(verb + word, (ct.c_uint * 1)(0), ct.c_size_t(1), (ct.c_double * 1)(), ct.c_size_t(1)) == ERROR
            assert word in one.said()
            assert one.call("Reset") == OK
    if two:
        return
    for name in ("GetClock", "SetClock", "GetIntervalDecimal", "GetShiftFraction", "SetIntervalFraction", "SetShiftDecimal"):
        assert one.call(name, None, ct.c_size_t(0), None, None, None) == OK
        assert one.call(name, (ct.c_uint * 1)(0), ct.c_size_t(1), None, None, None) == ERROR
        assert "Clock" in one.said()
        assert one.call("Reset") == OK
    assert one.call("GetFloat64", (ct.c_uint * 2)(0, 1), ct.c_size_t(2), (ct.c_double * 3)(), ct.c_size_t(3)) == ERROR
    assert "2 value references come with 3 values" in one.said()


def test_rivals_are_named_where_they_are_refused(one: Instance) -> None:
    assert one.set({"edge_force": 1, "proxy_lag": 1, "kienzle_force": 1}) == OK
    assert one.set_up() == OK
    assert one.call("ExitInitializationMode") == ERROR
    assert "rivals of each other: switch one of them off (edge_force and kienzle_force)" in one.said()


def test_input_derivatives_ramp_an_input_through_one_step(fmi2_fmu: Path, tmp_path: Path) -> None:
    one = Instance(Door(fmi2_fmu, tmp_path))
    one.start({"kinematics": 2, "friction_law": 1, "slip_velocity": 0.1, "F_C": 2.0})
    slip = (ct.c_uint * 1)(one.door.reference["slip_velocity"])
    first, count = (ct.c_int * 1)(1), ct.c_size_t(1)
    assert one.call("SetRealInputDerivatives", slip, count, first, (ct.c_double * 1)(100.0)) == OK
    assert one.step(0.0, 1e-3) == OK
    # 0.1 m/s + 100 m/s2 * 1 ms; Coulomb's 2 N over a way of 0.15 mm
    assert one.get("slip_velocity")[0] == pytest.approx(0.2, rel=1e-12)
    assert one.get("dissipated_energy")[0] == pytest.approx(3e-4, rel=1e-12)
    assert one.step(1e-3, 1e-3) == OK
    assert one.get("slip_velocity")[0] == pytest.approx(0.2, rel=1e-12)  # it held for that step only
    for order, value, reference, words in (
        (2, 1.0, slip[0], "order 1"),
        (1, float("nan"), slip[0], "finite"),
        (1, 1.0, one.door.reference["F_C"], "only inputs"),
        (1, 1.0, 99_999, "value reference 99999"),
    ):
        arrays = (ct.c_uint * 1)(reference), count, (ct.c_int * 1)(order), (ct.c_double * 1)(value)
        assert one.call("SetRealInputDerivatives", *arrays) == ERROR
        assert words in one.said()
        assert one.call("Reset") == OK
        one.start({"kinematics": 2, "slip_velocity": 0.1})
    assert one.call("SetRealInputDerivatives", slip, count, first, (ct.c_double * 1)(1e7)) == OK
    assert one.step(0.0, 1e-3) == ERROR  # it would lead to 1e4 m/s
    assert "slip_velocity" in one.said()
    assert one.call("Reset") == OK
    one.free()
