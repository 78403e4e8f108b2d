"""Does a coupled system move as nature does? The 1995 cases, energy, the order of the coupling, EVAT's forces, a measured axis."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import lugre_1995 as published
import numpy as np
import pytest
from coupled import motion, order, run
from evat import parameter_sets
from evat.native import kernel
from evat.native.coupling import Coupling
from evat.systems.couple import Coupled, Given, plan
from evat.systems.declared import load
from evat.systems.model import Connector, SspError
from evat.systems.run import run_system
from evat.systems.ssp.read import read
from evat.systems.values import from_set
from scipy.interpolate import CubicSpline
from scipy.io import loadmat

PUBLISHED = {"guideway": {"damping_mode": "as_published"}}
EMPS = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "emps" / "DATA_EMPS.mat"


def test_a_pulled_block_sticks_and_slips(systems: dict[str, Path]) -> None:
    trace, power = run(systems["stick_slip"], PUBLISHED, step=5e-4, stop=28.0)
    assert published.stick_slip(motion(trace)) == pytest.approx(published.STICK_SLIP, abs=published.TOLERANCE["ms"])
    ((passed, made, _),) = power.shares().values()
    assert passed > 1
    assert abs(made) < 1e-6 * passed


@pytest.mark.parametrize("sequence", ["gauss-seidel", "jacobi"])
def test_the_period_of_stick_slip_is_right_at_the_systems_own_step(systems: dict[str, Path], sequence: str) -> None:
    """1 ms, at which constant inputs are 0.027 % off (Gauss-Seidel) or 0.042 % (Jacobi)."""
    assert load("stick_slip").step == 1e-3
    period = published.stick_slip(motion(run(systems["stick_slip"], PUBLISHED, stop=28.0, order=sequence)[0]))["period"]
    assert period == pytest.approx(published.STICK_SLIP["period"], rel=2e-4)


@pytest.mark.campaign  # half a minute; through fmpy as an importer it hunts in each run of the tests
def test_a_servo_with_integral_action_hunts(systems: dict[str, Path]) -> None:
    simulated = published.hunting(motion(run(systems["hunting"], PUBLISHED)[0]))
    expected = dict(published.HUNTING)
    assert simulated.pop("period") == pytest.approx(expected.pop("period"), abs=published.TOLERANCE["hunting_period"])
    assert simulated == pytest.approx(expected, abs=published.TOLERANCE["ms"])


def test_the_portable_values_hardly_differ_from_the_published(systems: dict[str, Path]) -> None:
    """Some importers cannot set a choice; the damping that is dissipative at all speeds moves the period by less than 1 part in 2000."""
    simulated = published.stick_slip(motion(run(systems["stick_slip"], stop=28.0)[0]))
    assert simulated == pytest.approx(published.STICK_SLIP, rel=5e-4)


FREE = {
    "guideway": {"F_C": 1e-6, "F_S": 1e-6, "sigma0": 1.0, "sigma1": 0.0, "sigma2": 0.0},
    "drive": {"table_position": 0.1},
    "path": {"speed": 0.0},
}


def test_a_set_of_the_contact_goes_to_a_part_of_it_as_far_as_that_goes(systems: dict[str, Path], tmp_path: Path) -> None:
    """A guideway has few of the contact's effects. Any set was refused for switches of the others, which it leaves off."""
    system, named = read(systems["stick_slip"], tmp_path), parameter_sets.load("lugre-1995").by_choice
    assert from_set(system, "guideway", "lugre-1995") == {"load_dependence": False, **named}
    by_set, by_value = (
        run_system(systems["stick_slip"], stop=0.05, **given)  # type: ignore[arg-type]
        for given in ({"sets": {"guideway": "lugre-1995"}}, {"values": {"guideway": named}})
    )
    assert by_set["guideway.friction_force"].tobytes() == by_value["guideway.friction_force"].tobytes()
    with pytest.raises(SspError, match=r"copper switches on thermal_softening, thermal_damping, which .*guideway \(Evat"):
        from_set(system, "guideway", "regularised/copper")
    for reference, said in (("1 m/min", ""), ("2 m/min", "gives theta_ref, which the FMU of component guideway")):
        speed, unit = reference.split()
        own = f'base = "lugre-1995"\n[values]\ntheta_ref = {{ value = {speed}, unit = "{unit}" }}\n'
        (tmp_path / "mine.toml").write_text(own, encoding="utf-8")
        if said:
            with pytest.raises(SspError, match=said):
                from_set(system, "guideway", str(tmp_path / "mine.toml"))
        else:
            assert from_set(system, "guideway", str(tmp_path / "mine.toml")) == {"load_dependence": False, **named}


def test_without_friction_a_block_on_a_spring_keeps_its_energy(systems: dict[str, Path]) -> None:
    """30 swings; friction of 1e-6 N takes some 4 A F a swing, and no more may go."""
    swings, amplitude = 30, 0.1
    trace, _ = run(systems["stick_slip"], FREE, step=5e-3, stop=swings * 2 * np.pi / np.sqrt(2))
    energy = 0.5 * trace["drive.table_velocity"] ** 2 + trace["drive.table_position"] ** 2  # k = 2
    lost = 1 - energy / energy[0]
    allowed = swings * 4 * amplitude * 1e-6 / energy[0]
    assert np.all(np.abs(lost) < 1.1 * allowed)
    assert lost[-1] > 0.5 * allowed  # what friction there is, takes it


@pytest.mark.parametrize(("inputs", "claimed"), [("linear", 2), ("constant", 1)])
@pytest.mark.parametrize("sequence", ["gauss-seidel", "jacobi"])
def test_half_the_step_shows_the_order(systems: dict[str, Path], inputs: str, claimed: int, sequence: str) -> None:
    """A block that a spring drags, with viscous friction: smooth, so that nothing hides the order. Against the closed form."""
    values = {
        "guideway": {"F_C": 1e-6, "F_S": 1e-6, "sigma0": 1.0, "sigma1": 0.0, "sigma2": 0.4},
        "drive": {"table_position": 100.0},  # far: the least friction that a law allows, 1e-6 N, must not be seen
        "path": {"speed": 0.0},
    }
    stop, damped = 2.0, np.sqrt(2 - 0.2**2)
    exact = 100 * np.exp(-0.2 * stop) * (np.cos(damped * stop) + 0.2 / damped * np.sin(damped * stop))
    errors = []
    for step in (0.04, 0.02, 0.01, 0.005):
        trace, _ = run(systems["stick_slip"], values, step=step, stop=stop, inputs=inputs, order=sequence)
        errors.append(abs(trace["drive.table_position"][-1] - exact))
    assert order(errors) == pytest.approx(claimed, abs=0.15)


def test_the_power_balance_sees_a_step_that_is_too_long(systems: dict[str, Path]) -> None:
    _, fine = run(systems["stick_slip"], step=1e-3, stop=10.0, inputs="constant")
    _, coarse = run(systems["stick_slip"], step=1e-2, stop=10.0, inputs="constant")
    shares = [moved / passed for (passed, _, moved) in (*fine.shares().values(), *coarse.shares().values())]
    assert shares[1] > 5 * shares[0]
    assert "take steps of" not in fine.advice(1e-3, 1)[0]


@pytest.mark.parametrize(("inputs", "alike"), [("constant", 0.01), ("linear", 0.25)])
def test_what_the_coupling_made_is_what_the_books_of_the_components_lack(
    systems: dict[str, Path], tmp_path: Path, inputs: str, alike: float
) -> None:
    """A table of 1 kg that 1 N pushes over a viscous guideway: what it has and what the guideway took up is the work of the push, but for
    what the coupling made. It was told with the other sign. Held inputs lose ten times what those that are continued make."""
    system = read(systems["stick_slip"], tmp_path)
    guideway = system.components["guideway"]
    shown = {**guideway.connectors, "dissipated_energy": Connector("dissipated_energy", "output", "J")}
    system = replace(system, components={**system.components, "guideway": replace(guideway, connectors=shown)})
    values = {
        "drive": {"pid_gain": 0.0, "load_force": -1.0},
        "guideway": {"F_C": 1e-6, "F_S": 1e-6, "sigma0": 1e5, "sigma1": 1.0, "sigma2": 5.0},
    }
    with Coupled(system, values) as coupled:
        trace, power = coupled.run(plan(system, 0.02, 1.0, inputs=inputs))  # type: ignore[arg-type]
    ((_, made, _),) = power.shares().values()
    kinetic, work = 0.5 * trace["drive.table_velocity"][-1] ** 2, trace["drive.table_position"][-1]
    lacking = kinetic + trace["guideway.dissipated_energy"][-1] - work
    assert made == pytest.approx(lacking, rel=alike)
    assert (made < 0) == (inputs == "constant")
    assert abs(made) > 5e-5


def circle(systems: dict[str, Path]) -> tuple[np.ndarray, np.ndarray]:
    """Place on the circle [rad] and error of the radius [m] over the second turn."""
    trace, _ = run(systems["circular_path"], every=5)
    x, y, R = trace["drive_x.table_position"], trace["drive_y.table_position"] - 0.02, 0.02
    late = trace.times > 0.4
    return np.unwrap(np.arctan2(y, x))[late], (np.hypot(x, y) - R)[late]


def test_a_circle_shows_a_glitch_at_every_quadrant(systems: dict[str, Path]) -> None:
    """Where an axis turns round its friction changes sign, and the control needs time to learn it: a bump outwards."""
    angle, error = circle(systems)
    quarter = np.mod(angle + np.pi / 4, np.pi / 2) - np.pi / 4  # from the nearest crossing of an axis, ahead positive
    at, between = (quarter > 0.0) & (quarter < 0.25), np.abs(quarter) > 0.5
    assert np.max(error[at]) > 4e-6
    assert np.max(error[at]) > 4 * np.max(np.abs(error[between]))


@pytest.mark.slow
def test_vibration_lowers_the_forces_the_more_the_slower_the_cut(systems: dict[str, Path]) -> None:
    """Why EVAT exists. Mean forces of the coupled cut over those of conventional turning at the same speed: they fall with the speed
    ratio, thrust further than principal force where friction hardly depends on speed (as here: tests/laws/test_conventional.py), duty
    with them; at four times the speed ratio of separation thrust is conventional, principal force but for b of the feed, 5 %."""
    parameter_set = parameter_sets.load("regularised/al-7075-t6")
    material = {**kernel.by_choice(parameter_set.values), **dict.fromkeys(parameter_set.effects, True)}
    fastest = 5e-6 * 2 * np.pi * 20e3
    ratios, rows = (0.1, 0.3, 0.5, 0.8, 0.99, 4.0), []
    for ratio in ratios:
        turning = {name: ratio * fastest / 0.02 for name in ("speed_set", "spindle_speed", "speed_reference")}
        cut, plain = (
            run(systems["evat_turning"], {"spindle": turning, "contact": {**material, **still}}, stop=2e-3, every=1)[0]
            for still in ({}, {"amplitude_x": 0.0, "amplitude_y": 0.0})
        )
        late = cut.times >= 1e-3
        shares = [
            np.mean(cut[f"contact.{name}"][late]) / np.mean(plain[f"contact.{name}"][late]) for name in ("principal_force", "feed_force")
        ]
        rows.append([*shares, cut["contact.mean_contact_ratio"][-1]])
    principal, thrust, duty = np.array(rows).T
    assert np.all(np.diff(principal) > 0)
    assert np.all(np.diff(thrust) > 0)
    assert np.all(np.diff(duty[:-1]) > 0)
    assert np.all(thrust[:-1] < principal[:-1])
    assert principal[0] < 0.2
    assert thrust[0] < 0.01
    assert duty[:2] == pytest.approx((0.3120, 0.4235), abs=2e-3)  # physics: closed form of the ellipse on a rigid machine
    assert duty[-2] > 0.9
    assert duty[-1] == pytest.approx(1, abs=1e-9)
    assert 0.45 < thrust[-2] < 0.52  # at HSR = 0.99 friction still reverses, so thrust is far from conventional
    assert (principal[-1], thrust[-1]) == pytest.approx((0.955, 1), abs=5e-3)  # chip thinner by b = 5 um of 100 um; no reversal left


def test_an_input_keeps_its_own_start_until_its_source_is_shown(
    systems: dict[str, Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The contact is set before the heat that warms it: it was set to 0 K, and a contact that divides by it had failed at the start."""
    seen, set_inputs = list[np.ndarray](), Coupling.set

    def noting(loop: Coupling, member: int) -> None:
        seen.append(loop.signals.copy())
        set_inputs(loop, member)

    monkeypatch.setattr(Coupling, "set", noting)
    system = read(systems["evat_turning"], tmp_path / "in")
    with Coupled(system) as coupled:
        trace, _ = coupled.run(plan(system, stop=1e-6))
    temperature, speed = (coupled.signals[at] for at in (("heat", "contact_temperature"), ("spindle", "cutting_speed")))
    assert (seen[0][temperature], seen[0][speed]) == (293.15, pytest.approx(1 / 6))
    assert seen[-1][speed] == trace["spindle.cutting_speed"][0] != seen[0][speed]  # once shown, that of its source


def test_an_input_that_nothing_feeds_is_told(systems: dict[str, Path]) -> None:
    """The axis stood still without a word; a signal, or a value for it, is an answer."""
    reference, times = ("drive", "position_reference"), np.array([0.0, 0.01])
    unsaid = "nothing feeds drive.position_reference"
    assert str(run(systems["emps"], stop=0.01)[0].made_by["notes"]).startswith(unsaid)
    for given in (
        {"given": Given((reference,), times, np.array([[0.0], [1e-3]]))},
        {"values": {"drive": {"position_reference": 1e-3}}},
    ):
        assert "notes" not in run(systems["emps"], stop=0.01, **given)[0].made_by
    assert "notes" not in run(systems["stick_slip"], stop=0.01)[0].made_by


@pytest.mark.skipif(not EMPS.is_file(), reason="the EMPS record is not beside the checkout")
def test_the_measured_axis_is_followed(systems: dict[str, Path]) -> None:
    """EMPS: reference in, position and force out, parameters as published for it; the record is not fitted here."""
    data = loadmat(EMPS)
    t, reference, position, force = (data[name].ravel() for name in ("t", "qg", "qm", "vir"))
    force = force * float(data["gtau"].ravel()[0]) if "gtau" in data else force * 35.1507
    given = Given((("drive", "position_reference"),), t - t[0], reference[:, None])
    start = {"drive": {"table_position": float(position[0]), "motor_position": float(position[0])}}
    trace, _ = run(systems["emps"], start, given, stop=20.0)
    at = t - t[0] <= 20.0
    simulated = CubicSpline(trace.times, trace["drive.table_position"])(t[at] - t[0])
    assert np.sqrt(np.mean((simulated - position[at]) ** 2)) < 2e-5 * np.ptp(position)  # 5 um of 246 mm
    pushed = np.interp(t[at] - t[0], trace.times, trace["drive.motor_force"])
    assert np.sqrt(np.mean((pushed - force[at]) ** 2)) < 0.08 * np.sqrt(np.mean(force[at] ** 2))


@pytest.mark.campaign
@pytest.mark.parametrize(("name", "stop"), [("stick_slip", 12.0), ("hunting", 20.0), ("feed_drive", 2.0), ("circular_path", 3.0)])
def test_masters_that_hold_inputs_are_given_a_step_that_serves(systems: dict[str, Path], name: str, stop: float) -> None:
    """Friction within 1 % of its range, against a run at a sixteenth of our own step."""
    step, held = load(name).step, load(name).step_of_held_inputs
    good, _ = run(systems[name], step=step / 16, stop=stop, every=16)
    rough, _ = run(systems[name], step=held, stop=stop, every=round(step / held), inputs="constant", order="jacobi")
    assert held < 0.3 * step or name in ("feed_drive", "circular_path")
    for column, right in good.columns.items():
        if column.endswith(".friction_force"):
            assert np.max(np.abs(rough[column] - right)) < 0.01 * np.ptp(right)
