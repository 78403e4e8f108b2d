"""Which rig stands there? Draws the world of a case: friction rig, machine axis, elliptical vibration cut, or means over conditions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from .base_laws import Law, drawn_form
from .cutting import PHASE_X, PHASE_Y, Path, drawn_cut, drive_of
from .drive import Array, Drive
from .motions import AXIS, RIG, Motion
from .world import World

Draw = np.random.Generator
Slow = Callable[[Array], Array]


def logged(rng: Draw, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def _digits(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def _friction(rng: Draw, F_C: float, fast: float, stroke: float, *, flat: bool, dry: bool) -> dict[str, float]:
    """LuGre's parameters for a peak speed and a length of motion."""
    presliding = stroke / logged(rng, 12.0, 80.0)
    return {
        "F_C": _digits(F_C),
        "F_S": _digits(F_C if flat else F_C * float(rng.uniform(1.1, 1.7))),
        "v_s": _digits(fast * logged(rng, 0.03, 0.2)),
        "sigma0": _digits(F_C / presliding),
        "sigma1": _digits(F_C / fast * logged(rng, 0.01, 0.2)),
        "sigma2": 0.0 if dry else _digits(F_C / fast * float(rng.uniform(0.05, 0.45))),
    }


def _knowledge(rng: Draw, flat: bool) -> dict[str, float]:
    sd = {name: _digits(float(rng.uniform(0.08, 0.25)), 2) for name in ("F_C", "F_S", "sigma0", "sigma2")}
    sd |= {"sigma1": _digits(float(rng.uniform(0.2, 0.5)), 2), "v_s": _digits(float(rng.uniform(0.15, 0.35)), 2)}
    if flat:
        sd["F_S"] = sd["F_C"]
    return sd


def _slow(rng: Draw, span: float, mean: float, swing: float) -> Slow:
    """Warming up to a level, or wandering about it."""
    if rng.random() < 0.5:
        late, low = span * float(rng.uniform(0.25, 0.8)), mean * (1 - swing)
        return lambda t: low + 2 * mean * swing * -np.expm1(-np.maximum(t, 0.0) / late)
    turns, phase = float(rng.uniform(0.6, 2.6)) / span, float(rng.uniform(0, 2 * np.pi))
    return lambda t: mean * (1 + swing * np.sin(2 * np.pi * turns * t + phase))


def friction_rig(rng: Draw, law: str, *, axis: bool = False, needs: frozenset[str] = frozenset(), flat: bool = False, dry: bool = False,
                 motion: str = "", softened: bool = False) -> World:  # fmt: skip
    """A rig with slip in and friction out; or an axis with an encoder and a motor current."""
    every_motion = AXIS if axis else RIG
    kind = motion or str(rng.choice(list(every_motion)))
    f = logged(rng, 0.1, 2.0) if axis else logged(rng, 0.5, 40.0)
    stroke = logged(rng, 5e-3, 0.2) if axis else logged(rng, 1e-4, 1e-2)
    fast = 2 * stroke * f
    F_C = logged(rng, 15.0, 300.0) if axis else logged(rng, 1.0, 60.0)
    if axis:
        stroke /= 10  # a ball screw's presliding is small beside its travel
    params = _friction(rng, F_C, fast, stroke, flat=flat, dry=dry)
    count = int(rng.integers(3, 7))
    exact: dict[str, float | str] = {}
    hot = "theta" in needs or softened or rng.random() < 0.45
    by_temperature = hot and rng.random() < 0.3
    loaded = "load" in needs or (not axis and rng.random() < 0.4)
    if hot:
        exact = {"theta_ref": _digits(0.5 * fast, 2), "proxy_source": "contact_temperature" if by_temperature else "proxy_speed"}
    if by_temperature:
        exact |= {"ambient_temperature": 293.15, "reference_temperature": 393.15, "alpha_T": 0.5}
    nominal_effects: tuple[str, ...] = ()
    sd = _knowledge(rng, flat)
    if softened:
        nominal_effects, exact["thermal_softening.Q"] = ("thermal_softening",), _digits(float(rng.uniform(0.7, 1.5)), 2)
        hottest = 1.0 / float(exact["theta_ref"]) * 0.8 * fast
        params["thermal_softening.k_Q"] = _digits(
            params["sigma0"] * float(rng.uniform(0.2, 0.35)) / hottest ** float(exact["thermal_softening.Q"])
        )
        sd["thermal_softening.k_Q"] = 0.15
    shape_seed, same = int(rng.integers(1 << 30)), kind not in ("velocity_steps", "stops_and_dwells")
    tempo, speed = rng.permutation(np.geomspace(0.6, 1.6, count)), rng.permutation(np.geomspace(0.3, 1.0, count))
    motions = [every_motion[kind](np.random.default_rng([shape_seed, 0 if same else n])) for n in range(count)]
    spans = [m.periods / (f * q) for m, q in zip(motions, tempo, strict=True)]
    theta = [_slow(rng, s, fast * float(rng.uniform(0.2, 0.7)), float(rng.uniform(0.15, 0.5))) for s in spans] if hot else None
    load = [_slow(rng, s, float(rng.uniform(5, 16)), float(rng.uniform(0.05, 0.35))) for s in spans] if loaded else None
    slid_in, every = bool(rng.random() < 0.5), 5
    per = motions[0].per
    sampling = 1 / (per * f * float(np.max(tempo)))  # one clock for all conditions

    def trial(places: list[int], begins: Array | None = None, lengths: Array | None = None, scales: Array | None = None,
              factors: Mapping[str, float] = MappingProxyType({})) -> Drive:  # fmt: skip
        """begins: in periods; lengths: share of the whole; scales: of the speed; factors: of inputs, of a temperature that of its rise."""
        n = len(places)
        begins = np.zeros(n) if begins is None else begins
        lengths = np.ones(n) if lengths is None else lengths
        scales = np.ones(n) if scales is None else scales
        h = sampling / every
        first = int(per * every * 0.6) if slid_in else 0
        samples = np.array([max(60, min(int(spans[p] * q / sampling), 1600)) for p, q in zip(places, lengths, strict=True)])
        rows = first + int(np.max(samples) - 1) * every + 1
        t = np.repeat(((np.arange(rows) - first) * h)[:, None], n, axis=1)
        v = np.empty_like(t)
        for lane, p in enumerate(places):
            u = t[:, lane] * f * tempo[p] + begins[lane]
            v[:, lane] = factors.get("slip_velocity", 1.0) * fast * speed[p] * scales[lane] * motions[p].velocity(u)
        x = np.zeros_like(v)
        x[1:] = np.cumsum((v[1:] + v[:-1]) / 2, axis=0) * h

        def own(signals: list[Slow] | None, factor: float) -> Array | None:
            return None if signals is None else factor * np.stack([signals[p](t[:, lane]) for lane, p in enumerate(places)], axis=1)

        heat = factors.get("proxy_speed", 1.0) * factors.get("contact_temperature", 1.0) ** (1 / float(exact.get("alpha_T", 1.0)))
        values = tuple({} for _ in places)
        return Drive(h, t, v, x, first, every, samples, own(theta, heat), own(load, factors.get("normal_load", 1.0)), values=values)

    inputs = ["slip_velocity"]
    if hot:
        inputs.append("contact_temperature" if by_temperature else "proxy_speed")
    if loaded:
        inputs.append("normal_load")
    notes = {"fast": fast, "slid_in": float(slid_in), "sampling": sampling, "mass": F_C / (fast * f) * float(rng.uniform(0.005, 0.05))}
    return World(
        ("axis/" if axis else "rig/") + kind, ("friction_force",), Law(law, drawn_form(law, rng)), Law("sharp"), params, exact, sd,
        trial(list(range(count))), trial, tuple(f * q if motions[0].periodic else 0.0 for q in tempo.tolist()), tuple(inputs),
        nominal_effects=nominal_effects, notes=notes,
    )  # fmt: skip


def turning(rng: Draw, law: str, cut: str, *, means: bool = False, needs: frozenset[str] = frozenset(), flat: bool = False,
            dry: bool = False, **_: Any) -> World:  # fmt: skip
    """Elliptical vibration assisted turning: dynamometer records of a few cycles, or means of many conditions."""
    f = float(rng.choice([17.6e3, 20e3, 20e3, 20e3, 21.5e3, 28e3]))
    a, b = _digits(float(rng.uniform(3e-6, 9e-6)), 3), _digits(float(rng.uniform(2.5e-6, 7e-6)), 3)
    width, feed = (
        _digits(float(rng.uniform(0.4e-3, 2e-3)), 3),
        _digits(b * float(rng.choice([rng.uniform(0.3, 0.8), rng.uniform(1.2, 4.0)])), 3),
    )
    rake, flow = float(rng.choice([0.0, 0.0, 0.0, 0.087, -0.087])), _digits(float(rng.uniform(0.38, 0.75)), 3)
    tau = _digits(float(rng.uniform(2.5e8, 7e8)), 4)
    fast = 2 * np.pi * f * b
    shear = tau * width * min(feed, 2 * b)
    params = _friction(rng, shear * float(rng.uniform(0.25, 0.9)), fast, b, flat=flat, dry=dry) | {"shear_stress": tau}
    sd = _knowledge(rng, flat) | {"shear_stress": _digits(float(rng.uniform(0.05, 0.15)), 2)}
    if means:
        sd = {name: min(value, 0.1) for name, value in sd.items()}
    principle = str(rng.choice(["maximum_shear_stress", "minimum_energy"]))
    exact: dict[str, float | str] = {
        "vibration_frequency": f, "amplitude_x": a, "amplitude_y": b, "width": width, "rake_angle": rake, "chip_flow_shear_angle": flow,
        "feed": feed, "phase_x": float(PHASE_X), "phase_y": float(PHASE_Y), "shear_angle_principle": principle,
    }  # fmt: skip
    limit = 2 * np.pi * f * a
    hot = "theta" in needs or rng.random() < 0.5
    if hot:
        exact |= {"proxy_source": "cutting_speed", "theta_ref": _digits(0.3 * limit, 2)}
    count = int(rng.integers(10, 19)) if means else int(rng.integers(3, 7))
    ratio = rng.permutation(np.geomspace(0.06, 0.65, count))
    feeds = np.exp(rng.uniform(np.log(0.6), np.log(1.5), count)) if means or rng.random() < 0.5 else np.ones(count)
    sizes = rng.uniform(0.75, 1.2, count) if means and rng.random() < 0.5 else np.ones(count)
    runs = [
        {"cutting_speed": _digits(q * limit), "feed": _digits(feed * m), "amplitude_y": _digits(b * z)}
        for q, m, z in zip(ratio, feeds, sizes, strict=True)
    ]
    per_trial = ("cutting_speed", *(["feed"] if np.ptp(feeds) else []), *(["amplitude_y"] if np.ptp(sizes) else []))
    runs = [{name: run[name] if name in per_trial else float(exact[name]) for name in run} for run in runs]
    cycles, per, every = (1.0, 120, 16) if means else (float(rng.integers(3, 8)), int(rng.integers(48, 100)), 10)
    start = float(rng.uniform(0, 1)) if not means and rng.random() < 0.5 else 0.5  # in cycles; 0.5: the tool is out of the cut

    def trial(places: list[int], begins: Array | None = None, lengths: Array | None = None, scales: Array | None = None,
              factors: Mapping[str, float] = MappingProxyType({})) -> Drive:  # fmt: skip
        n, own = len(places), [{name: value * factors.get(name, 1.0) for name, value in runs[p].items()} for p in places]
        begins = np.zeros(n) if begins is None else begins
        lengths = np.ones(n) if lengths is None else lengths
        scales = np.ones(n) if scales is None else scales
        paths = [
            Path(
                own[i]["cutting_speed"] * scales[i], own[i]["feed"], a, own[i]["amplitude_y"], f, rake, flow,
                (round((start + begins[i]) * per) / per) / f, max(2.0, cycles * lengths[i]) if not means else 1.0, per,
            )
            for i in range(n)
        ]  # fmt: skip
        theta = np.array([run["cutting_speed"] for run in own]) if hot else None
        return drive_of(paths, every, tuple({n_: run[n_] for n_ in per_trial} for run in own), theta)

    numbers = drawn_cut(cut, rng, shear, width, min(feed, 2 * b), 0.3 * limit)
    channels = ("mean_principal_force", "mean_feed_force") if means else ("principal_force", "feed_force")
    return World(
        "means" if means else "ellipse", channels, Law(law, drawn_form(law, rng)), Law(cut, numbers), params, exact, sd,
        trial(list(range(count))), trial, (f,) * count, (), per_trial, means=means,
        notes={"fast": fast, "slid_in": 1.0, "sampling": 1 / (f * per), "shear": shear},
    )  # fmt: skip


def motion_of(name: str, rng: Draw) -> Motion:
    """A motion by its name, of a rig or an axis."""
    return {**RIG, **AXIS}[name](rng)
