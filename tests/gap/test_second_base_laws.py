"""Do the second reality's laws have the properties that their authors published, and is its LuGre the package's own?"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from evat.model import Run
from evat.models.contact import ContactModel
from second_reality import catalogue
from second_reality.base_laws import LAWS, Contact, Law, contact_age, drawn_form, friction, strength
from second_reality.cutting import held_of
from second_reality.drive import Array, Drive
from second_reality.rigs import friction_rig, turning
from second_reality.world import World

F_C, F_S, V_S, SIGMA0 = 10.0, 13.0, 1e-3, 1e6
PRESLIDING = F_C / SIGMA0


def contact(v: Array, h: float, **changed: float) -> Contact:
    """A contact moved at v (rows), one lane."""
    v = np.atleast_2d(v).T if v.ndim == 1 else v
    t = np.repeat((np.arange(v.shape[0]) * h)[:, None], v.shape[1], axis=1)
    x = np.zeros_like(v)
    x[1:] = np.cumsum((v[1:] + v[:-1]) / 2, axis=0) * h
    drive = Drive(h, t, v, x, 0, 1, np.full(v.shape[1], v.shape[0]))
    given = {"F_C": F_C, "F_S": F_S, "v_s": V_S, "sigma0": SIGMA0, "sigma1": 0.0, "sigma2": 0.0} | changed
    one = np.ones_like(v)
    fields = [given[name] * one for name in ("F_C", "F_S", "v_s", "sigma0", "sigma1", "sigma2")]
    return Contact(drive, *fields, one.copy(), one.copy(), 0.0 * one)


def through(stations: list[float], speed: float, per: int = 1500) -> tuple[Array, float, list[int]]:
    """Velocity of a path through these places at one speed, and the row at which each is reached."""
    h = abs(stations[1] - stations[0]) / speed / per
    parts, rows = [np.zeros(1)], [0]
    for a, b in itertools.pairwise(stations):
        n = round(abs(b - a) / (speed * h))
        parts.append(np.full(n, np.sign(b - a) * speed))
        rows.append(rows[-1] + n)
    return np.concatenate(parts), h, rows


@pytest.mark.parametrize("law", list(LAWS))
def test_a_steady_slip_meets_the_published_curve(law: str) -> None:
    rng = np.random.default_rng(4)
    form = drawn_form(law, rng)
    for speed in (0.5 * V_S, 20 * V_S):
        c = contact(np.full(1500, speed), 60 * PRESLIDING / speed / 1500)
        if law == "rate_and_state":
            b = (F_S / F_C - 1) / np.log(1 + 10 * form["fast"])
            V_0 = form["fast"] * V_S
            curve = F_C * (1 + form["direct"] * b * np.log1p(speed / (0.01 * V_S)) + b * np.log1p(V_0 / speed))
        elif law == "lagged_coulomb":
            curve = float(strength(c, {"hyperbola": 2.0})[-1, 0]) * 2 / np.pi * np.arctan(speed / (form["sharp"] * V_S))
        else:
            curve = float(strength(c, form if law.startswith("lugre") else {})[-1, 0])
        assert friction(c, Law(law, form))[-1, 0] == pytest.approx(curve, rel=0.01)


@pytest.mark.parametrize("law", list(LAWS))
def test_friction_takes_energy_over_a_closed_cycle_and_mirrors_its_path(law: str) -> None:
    form = drawn_form(law, np.random.default_rng(5))
    t = np.linspace(0, 3, 1801)
    v = 30 * PRESLIDING * 2 * np.pi * np.sin(2 * np.pi * t)
    both = friction(contact(np.stack([v, -v], axis=1), float(t[1])), Law(law, form))
    assert np.max(np.abs(both[:, 0] + both[:, 1])) < 1e-9 * F_C
    cycle = slice(1200, 1801)
    work = np.trapezoid(both[cycle, 0] * v[cycle], t[cycle])
    assert work > 0.5 * F_C * 4 * 30 * PRESLIDING


def test_maxwell_slip_remembers_inner_loops_and_forgets_them_where_they_close() -> None:
    """Nonlocal memory (Al-Bender, Lampaert and Swevers 2005): an inner loop closes, and behind it the path goes on as without it. LuGre, a
    law with one state, drifts."""
    form = {"count": 6, "spread": 3.0, "attraction": 0.2}
    outer, low, high = 0.9 * PRESLIDING, 0.2 * PRESLIDING, 0.6 * PRESLIDING
    with_loop = [0.0, outer, low, high, low, -0.5 * outer]
    without = [0.0, outer, low, -0.5 * outer]
    gap = {}
    for law in ("generalised_maxwell_slip", "lugre"):
        v, h, rows = through(with_loop, 0.01 * V_S)
        looped = friction(contact(v, h), Law(law, form if law != "lugre" else {}))[:, 0]
        v, h, plain_rows = through(without, 0.01 * V_S)
        plain = friction(contact(v, h), Law(law, form if law != "lugre" else {}))[:, 0]
        gap[law] = (abs(looped[rows[4]] - looped[rows[2]]), abs(looped[rows[5]] - plain[plain_rows[3]]))
    assert max(gap["generalised_maxwell_slip"]) < 2e-3 * F_C
    assert min(gap["lugre"]) > 1e-2 * F_C


def test_leuven_is_a_spring_at_first_and_with_a_sharp_transition_its_hysteresis_alone() -> None:
    """Swevers et al. 2000: dz/dt = v far below break-away, the more so the larger n; then loops close as those of Maxwell elements do."""
    form = {"count": 6, "spread": 3.0, "power": 20.0}
    v, h, rows = through([0.0, 0.6 * PRESLIDING, 0.1 * PRESLIDING, 0.4 * PRESLIDING, 0.1 * PRESLIDING], 0.01 * V_S, 1200)
    force = friction(contact(v, h), Law("leuven", form))[:, 0]
    assert abs(force[rows[4]] - force[rows[2]]) < 2e-3 * F_C
    assert force[20] == pytest.approx(SIGMA0 * np.sum(v[:21]) * h, rel=0.03)


def test_state_evolves_over_d_c_and_answers_a_step_of_speed_directly() -> None:
    """Dieterich 1979 and Ruina 1983: theta goes from d_c/v_1 to d_c/v_2 as exp(-slip/d_c); friction jumps by a ln(v_2/v_1) and then
    comes down by b ln(v_2/v_1)."""
    d_c, v_1, v_2, before = 5 * PRESLIDING, 2e-6, 2e-5, 30000
    h = 0.002 * d_c / v_2
    c = contact(np.concatenate([np.full(before, v_1), np.full(6000, v_2)]), h)
    theta = contact_age(c.drive, d_c)[before:, 0]
    slip = c.drive.x[before:, 0] - c.drive.x[before, 0]
    assert theta == pytest.approx(d_c / v_2 + (d_c / v_1 - d_c / v_2) * np.exp(-slip / d_c), rel=1e-2)

    form = {"direct": 0.5, "d_c": 5.0, "fast": 5.0}
    force, b = friction(c, Law("rate_and_state", form))[:, 0], (F_S / F_C - 1) / np.log(1 + 10 * form["fast"])

    def steady(speed: float) -> float:
        return float(F_C * (1 + 0.5 * b * np.log1p(speed / (0.01 * V_S)) + b * np.log1p(form["fast"] * V_S / speed)))

    assert force[before - 10] == pytest.approx(steady(v_1), rel=2e-3)
    assert force[-1] == pytest.approx(steady(v_2), rel=2e-3)
    jump = F_C * 0.5 * b * (np.log1p(v_2 / (0.01 * V_S)) - np.log1p(v_1 / (0.01 * V_S)))
    assert 0.05 * jump < force[before:].max() - steady(v_1) < jump  # rounded by the bristles' own slip
    assert steady(v_2) < steady(v_1)


def test_a_lagging_coulomb_law_is_larger_while_the_motion_speeds_up() -> None:
    """Hess and Soom 1990: over one-way motion friction opens into a loop, higher while accelerating where the curve falls."""
    t = np.linspace(0, 2, 8001)
    v = V_S * (2 + 1.5 * np.sin(2 * np.pi * t / 1.0))
    c = contact(v, float(t[1]), sigma0=SIGMA0 / 400)
    force = friction(c, Law("lagged_coulomb", {"lag": 3.0, "sharp": 0.1, "quick": 0.5}))[4000:, 0]
    speed, rising = v[4000:], np.gradient(v)[4000:] > 0
    middle = np.abs(speed - 2 * V_S) < 0.2 * V_S
    assert force[middle & rising].mean() > force[middle & ~rising].mean() * 1.005


def test_contact_begins_within_the_step_in_which_the_tool_enters() -> None:
    t = np.linspace(0, 1, 11)[:, None]
    held = held_of(t - 0.42, np.ones_like(t))
    assert held[:5, 0].tolist() == [0.0] * 5
    assert held[5, 0] == pytest.approx(0.8)
    assert held[6:, 0].tolist() == [1.0] * 5


def runs(world: World, lane: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """The channels of one lane, here and by the package's contact."""
    d = world.conditions
    values = {**world.params, **world.exact, **d.values[lane], "friction_law": "lugre"}
    values["kinematics"] = "external" if world.inputs else "internal"
    values.pop("proxy_source", None)
    inputs = {"slip_velocity": d.v[d.first :, lane]} if world.inputs else {}
    trace = ContactModel(1).simulate(Run(d.t[d.first :, lane], inputs, world.channels), (), values)
    forces = world.respond(d, [world.params])[0]
    own = {name: d.sampled(forces[name], lane) for name in world.channels}
    return own, {name: trace.columns[name][:: d.every][: d.count[lane]] for name in world.channels}


@pytest.mark.parametrize("kind", ["rig", "axis", "ellipse"])
@pytest.mark.parametrize("seed", [0, 3])
def test_the_right_form_is_the_packages_own_contact(kind: str, seed: int) -> None:
    """Both integrate the same equations; a thousandth is far below any noise that is put on them. The start differs where the record
    begins in motion: the first third is left out."""
    rng = np.random.default_rng(seed)
    world = turning(rng, "lugre", "sharp") if kind == "ellipse" else friction_rig(rng, "lugre", axis=kind == "axis")
    own, theirs = runs(world, 0)
    for name, force in own.items():
        rest = slice(force.size // 3, None)
        off = np.sqrt(np.mean((force[rest] - theirs[name][rest]) ** 2))
        assert off < 1e-3 * np.sqrt(np.mean(force**2))


def test_means_are_those_of_the_packages_periodic_motion() -> None:
    world = turning(np.random.default_rng(1), "lugre", "sharp", means=True)
    own = world.clean()
    size = {name: np.sqrt(np.mean([part[name][0] ** 2 for part in own])) for name in world.channels}
    for lane in range(0, len(own), 4):
        values = {**world.params, **world.exact, **world.conditions.values[lane], "friction_law": "lugre", "kinematics": "internal"}
        values.pop("proxy_source", None)
        settled = ContactModel(1).settled(world.channels, (), values | {"F_C": np.array([world.params["F_C"]])})
        for name in world.channels:
            assert abs(own[lane][name][0] - settled[name][0]) < 2e-3 * size[name]


def shortened(d: Drive) -> Drive:
    """Its first rows, for a quick run; a path is kept whole."""
    if d.path:
        return d
    rows = min(d.v.shape[0], d.first + 2500)
    cut = {name: None if (a := getattr(d, name)) is None else a[:rows] for name in ("t", "v", "x", "theta", "load")}
    return replace(d, count=np.array([(rows - d.first) // d.every]), **cut)


@pytest.mark.parametrize("name", list(catalogue.EFFECTS))
def test_an_effect_of_strength_nothing_does_nothing_and_at_its_usual_strength_something(name: str) -> None:
    """Each form in the first world that it belongs to."""
    kind = catalogue.EFFECTS[name]
    for split in catalogue.SPLITS:
        for how, make in catalogue.forms(split, name).items():
            rng = np.random.default_rng(11)
            needs = frozenset(kind.needs)
            if kind.worlds[0] in ("ellipse", "means"):
                world = turning(rng, "lugre", "sharp", needs=needs)
            else:
                world = friction_rig(
                    rng, "lugre", axis=kind.worlds[0] == "axis", needs=needs, softened="softened" in needs,
                    motion="stops_and_dwells" if "rests" in needs else "",
                )  # fmt: skip
            d = shortened(world.conditions.lane([0]))
            effect = make(world, rng)
            plain = world.respond(d, [world.params])[0]
            size = max(float(np.sqrt(np.mean(fine**2))) for fine in plain.values())
            for s, least, most in ((0.0 if "amplitude" not in name else 1e-9, 0.0, 2e-3), (effect.typical, 1e-4, 50.0)):
                changed = world.respond(d, [world.params], [(effect, s)])[0]
                off = max(float(np.sqrt(np.mean((changed[n] - plain[n]) ** 2))) for n in plain)
                assert least * size <= off <= most * size, f"{name} {how} at {s}: {off / size:.2g}"
