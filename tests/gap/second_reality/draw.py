"""What is the truth of a case, and how does it reach its owner? Draws world, effects and their size, noise, set-up, the nominal model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from where import places_of

from . import catalogue, recording, refit, unknowns
from .drive import Array, Channels, Drive
from .recording import Shared, Trial
from .rigs import friction_rig, logged, turning
from .world import Acting, Effect, World

Draw = np.random.Generator
NOISE = (0.006, 0.04)  # rms of one recording's noise over that of the force
MEANS_NOISE = (0.003, 0.02)
QUIETEST = 0.002
LEAST_OF_PAIR = 0.25  # of a pair's gap, that each leaves when the other is known
FORM_GAP = (0.4, 3.0)  # rms that the nearest LuGre leaves of another base law, over the noise


class NotDrawn(Exception):
    """These draws make no case: an effect has no say here, or not enough."""


@dataclass(frozen=True)
class Plan:
    world: str
    truth: str
    effects: tuple[str, ...]
    stratum: str
    law: str
    cut: str

    @property
    def form(self) -> str:
        return "right" if (self.law, self.cut) == ("lugre", "sharp") else "other"


@dataclass(frozen=True)
class Case:
    world: World
    nominal: dict[str, float]
    trials: list[Trial]
    shared: Shared
    label: dict[str, Any]
    oracle: dict[str, Array]
    mean_sd: dict[str, float] | None


def world_of(plan: Plan, rng: Draw) -> World:
    """A world in which all these effects could act; what one of them needs, others have at times, too."""
    needs = frozenset(n for name in plan.effects if name in catalogue.EFFECTS for n in catalogue.EFFECTS[name].needs)
    flat = "flat" in needs or rng.random() < 0.12
    dry = ("viscous_friction" in plan.effects and rng.random() < 0.7) or ("thermal_viscosity" not in plan.effects and rng.random() < 0.12)
    if plan.world in ("ellipse", "means"):
        return turning(rng, plan.law, plan.cut, means=plan.world == "means", needs=needs, flat=flat, dry=dry)
    return friction_rig(
        rng, plan.law, axis=plan.world == "axis", needs=needs, flat=flat, dry=dry, motion="stops_and_dwells" if "rests" in needs else "",
        softened="softened" in needs or ("thermal_softening" not in plan.effects and rng.random() < 0.08),
    )  # fmt: skip


def shared_share(world: World, share: float) -> World:
    """The world with its other forms brought nearer to the nominal model's."""
    return replace(world, law=replace(world.law, share=share), cut=replace(world.cut, share=share))


@dataclass
class Bench:
    """What every size is measured by: the records without effects, their units, and what a refit could do."""

    world: World
    noise: float
    sd: Array
    plain: list[Channels]
    unit: dict[str, float]
    J: Array

    @classmethod
    def of(cls, world: World, noise: float) -> Bench:
        plain = world.clean()
        unit = refit.sizes(world, plain)
        if not all(np.isfinite(u) and u > 0 for u in unit.values()):
            raise NotDrawn("a channel shows nothing")
        _, J, plain = refit.sensitivity(world, world.params, unit)
        return cls(world, noise, np.array([world.sd[name] for name in world.free]), plain, unit, J)

    def row(self, parts: list[Channels]) -> Array:
        return refit.flat(self.world, parts, self.unit)

    def structural(self, parts: list[Channels], base: list[Channels] | None = None) -> tuple[float, Array]:
        """What a gap leaves after the refit: its rms over that of the force in the channel where it is largest, and all of it."""
        r = refit.left(self.row(parts) - self.row(base or self.plain), self.J, self.sd, self.noise)
        if not np.all(np.isfinite(r)):
            raise NotDrawn("forces without bounds")
        return max(refit.per_channel(self.world, self.plain, r).values()), r

    def strength(self, effect: Effect, target: float, rng: Draw, others: Acting = ()) -> tuple[float, float]:
        """The strength at which the effect leaves the target beside others, and what it does leave."""
        base = self.world.clean(acting=others) if others else self.plain
        sign = float(rng.choice([-1, 1])) if effect.both_ways else 1.0
        s, size = effect.typical, 0.0
        for _ in range(9):
            size, _ = self.structural(self.world.clean(acting=[*others, (effect, sign * s)]), base)
            if 0.93 < size / target < 1.07 or (s >= effect.most and size < target):
                break
            s = float(np.clip(s * np.clip(target / max(size, 1e-12), 0.15, 6.0), 1e-4 * effect.most, effect.most))
        if s < effect.least:
            raise NotDrawn(f"{effect.name} would be too fine for the clock")
        return sign * s, size


@dataclass(frozen=True)
class Truth:
    """What acts in a case, before anything is measured. near: the nearest LuGre; left: what it leaves, over the rms of the force."""

    world: World
    bench: Bench
    acting: list[tuple[Effect, float]]
    near: dict[str, float]
    left: float
    noise: float
    ratio: float


def truth_of(plan: Plan, split: str, rng: Draw) -> Truth:
    """World, effects and their strengths; the same numbers give the same truth."""
    world = world_of(plan, rng)
    noise = logged(rng, *(MEANS_NOISE if world.means else NOISE))
    ratio = logged(rng, *catalogue.STRATA[plan.stratum])
    form_gap = logged(rng, *FORM_GAP)
    bench = Bench.of(world, noise)
    makers = []
    for name in plan.effects if plan.truth in ("single", "pair") else ():
        of_split = catalogue.forms(split, name)
        makers.append(of_split[str(rng.choice(list(of_split)))](world, rng))
    if makers:  # a world in which the effect shows too little for its stratum has a quieter sensor
        noise = _quiet_enough(bench, makers, ratio, noise, rng)
    world, near, left = _nearest(replace(world), plan, bench, noise, form_gap)
    bench = Bench.of(world, noise)
    acting: list[tuple[Effect, float]] = []
    shares = (1.0,) if len(makers) == 1 else (1.0, float(rng.uniform(0.5, 1.0)))
    for effect, share in zip(makers, shares, strict=False):
        s, _ = bench.strength(effect, share * ratio * noise / (1.2 if len(makers) > 1 else 1.0), rng, acting)
        acting.append((effect, s))
    return Truth(world, bench, acting, near, left, noise, ratio)


def draw_case(plan: Plan, split: str, seed: list[int]) -> Case:
    """One case of this plan; NotDrawn where it does not come off."""
    rng = np.random.default_rng(seed)
    truth = truth_of(plan, split, rng)
    world, bench, acting, near = truth.world, truth.bench, truth.acting, truth.near
    noise, ratio = truth.noise, truth.ratio
    full = world.clean(acting=acting)
    size, gap = bench.structural(full)
    nominal = _believed(plan, bench, near, ratio, noise, rng)
    names = {name: noise * float(rng.uniform(0.9, 1.0)) for name in world.channels}
    top = max(refit.per_channel(world, bench.plain, gap), key=lambda n: refit.per_channel(world, bench.plain, gap)[n])
    names[top] = noise
    shared = recording.drawn(world, rng, names)
    places, drive = recording.schedule(world, shared, rng)
    fine = world.respond(drive, [world.params], acting)[0]
    strange, unknown_size = None, 0.0
    if plan.truth == "unknown":
        strange, unknown_size, size = _strange(plan, bench, drive, places, fine, ratio * noise, seed)
    trials = _trials(world, drive, places, fine, strange, shared, seed)
    top_unit = bench.unit[top] * noise
    outputs_off = np.concatenate([t.ideal[top] - t.true[top] for t in trials])
    recorded_as = world.respond(recording.as_recorded(drive, trials), [world.params], acting)[0]
    inputs_off = (
        np.concatenate([drive.sampled(recorded_as[top] - fine[top], k) for k in range(drive.lanes)]) if world.inputs else np.zeros(1)
    )
    label = _label(plan, bench, acting, full, gap, shared, trials, places)
    if plan.truth == "mistuned":
        size = _off(bench, near, nominal)
    label |= {
        "seed": seed, "split": split, "plan": asdict(plan), "ratio": size / noise, "share_of_force": size, "noise_share": noise,
        "form_gap_over_noise": truth.left / noise,
        "form_share": world.law.share if plan.form == "other" else 0.0, "nominal": nominal, "nearest_lugre": near,
        "outputs_off_over_noise": float(np.sqrt(np.mean(outputs_off**2))) / top_unit,
        "inputs_off_over_noise": float(np.sqrt(np.mean(inputs_off**2))) / top_unit,
        "nominal_off": _off(bench, near, nominal) / noise,
        "unknown": {"kind": plan.effects[0], "strength": unknown_size} if plan.truth == "unknown" else None,
    }  # fmt: skip
    if plan.truth != "none":
        low, high = catalogue.STRATA[plan.stratum]
        if not 0.93 * low <= size / noise <= 1.07 * high:
            raise NotDrawn(f"the gap is {size / noise:.2g} of the noise, not {low} to {high}")
    if min(label["seen_beside"].values(), default=np.inf) < LEAST_OF_PAIR * ratio:
        raise NotDrawn("one of the two hides behind the other")
    mean_sd = {n: noise * float(rng.uniform(0.8, 1.25)) for n in world.channels} if world.means and rng.random() < 0.5 else None
    return Case(world, nominal, trials, shared, label, _oracle(world, bench.plain, full, bench.row(full) - gap, bench), mean_sd)


def with_another_condition(case: Case, plan: Plan, split: str, seed: list[int], place: int, factors: Mapping[str, float]) -> Case:
    """The case of these numbers, and two recordings by the same rig of one more condition: that of a place with other inputs or values."""
    truth = truth_of(plan, split, np.random.default_rng(seed))
    world, rng, shared = case.world, np.random.default_rng([*seed, 5]), case.shared
    begins, scales = shared.repeats_out_of_step * rng.random(2), 1 + shared.speed_scatter * rng.standard_normal(2)
    drive = world.trial([place, place], begins, np.ones(2), scales, factors)
    fine = world.respond(drive, [world.params], truth.acting)[0]
    usual = {n: float(np.sqrt(np.mean(np.concatenate([t.true[n] for t in case.trials]) ** 2))) for n in world.channels}
    own = refit.sizes(world, world.samples(fine, drive))
    if not all(np.isfinite(size) and size > 0 for size in own.values()):
        raise NotDrawn("a channel shows nothing there")
    more = {n: usual[n] / own[n] for n in world.channels}  # noise and zero are the sensor's, whatever the force is
    same = replace(
        shared,
        noise={n: more.get(n, 1.0) * value for n, value in shared.noise.items()},
        zero={n: more.get(n, 1.0) * value for n, value in shared.zero.items()},
    )
    new = world.conditions.lanes
    trials = _trials(world, drive, [new, new], fine, None, same, [*seed, 6])
    conditions = replace(world.conditions, values=(*world.conditions.values, drive.values[0]))
    return replace(case, world=replace(world, conditions=conditions), trials=[*case.trials, *trials])


def _quiet_enough(bench: Bench, makers: list[Effect], ratio: float, noise: float, rng: Draw) -> float:
    for effect in makers:
        _, size = bench.strength(effect, ratio * noise, np.random.default_rng(1))
        if not np.isfinite(size) or size < 1e-6:
            raise NotDrawn(f"{effect.name} has no say")
        noise = min(noise, size / ratio)
    if noise < QUIETEST:
        raise NotDrawn(f"{makers[0].name} would need a noise of {noise:.2g}")
    return noise


def _nearest(world: World, plan: Plan, bench: Bench, noise: float, wanted: float) -> tuple[World, dict[str, float], float]:
    """The world with its form near enough to LuGre's, the nearest LuGre to it, and what that leaves (of the rms of the force)."""
    if plan.form == "right":
        return world, dict(world.params), 0.0
    for _ in range(3):
        target = world.clean()
        near, r = refit.nearest_lugre(world, target, bench.unit)
        left = max(refit.per_channel(world, target, r).values())
        if left < wanted * noise * 1.3:
            break
        world = shared_share(world, world.law.share * max(wanted * noise / left, 0.02))
    if left > 2 * wanted * noise:
        raise NotDrawn("the base law's form is too far from LuGre's")
    return world, near, left


def _believed(plan: Plan, bench: Bench, near: Mapping[str, float], ratio: float, noise: float, rng: Draw) -> dict[str, float]:
    """What the owner believes: all a little off; or some by so much that the gap of the nominal values has the wanted size."""
    world = bench.world
    ways = rng.uniform(-0.6, 0.6, len(world.free))
    if plan.truth == "mistuned":
        ways = rng.choice([-1, 1], ways.size) * rng.uniform(0.4, 1.0, ways.size)
        ways[rng.permutation(ways.size)[int(rng.integers(1, 4)) :]] *= 0.1
    scale = 1.0

    def at(scale: float) -> dict[str, float]:
        off = np.clip(scale * ways, -2.5, 2.5) * bench.sd
        return {**near, **{n: float(f"{near[n] * max(1 + q, 0.15):.4g}") for n, q in zip(world.free, off, strict=True)}}

    for _ in range(6 if plan.truth == "mistuned" else 0):
        size = _off(bench, near, at(scale))
        if 0.95 < size / (ratio * noise) < 1.05:
            break
        scale = float(np.clip(scale * ratio * noise / max(size, 1e-9), 0.02, 6.0))
    params = at(scale)
    return {name: float(f"{value:.4g}") if name in world.free else value for name, value in params.items()}


def _off(bench: Bench, near: Mapping[str, float], nominal: Mapping[str, float]) -> float:
    """How far the forces of the nominal values are from those of the nearest LuGre."""
    world, d = bench.world, bench.world.conditions
    one, two = (world.samples(forces, d) for forces in world.respond(d, [near, nominal], (), refit.LUGRE, refit.SHARP))
    return max(refit.per_channel(world, one, bench.row(two) - bench.row(one)).values())


def _seen(world: World, bench: Bench, drive: Drive, lane: int, place: int, forces: Channels) -> unknowns.Seen:
    unit = {n: bench.unit[n] for n in world.channels}
    d, m = drive, world.means
    return unknowns.Seen(
        d.sampled(d.t, lane), d.sampled(d.v, lane), d.sampled(d.x, lane), forces, place, world.conditions.lanes,
        dict(d.values[lane]), unit, float(np.max(np.ptp(world.conditions.x, axis=0))),
        float(max(v["cutting_speed"] for v in world.conditions.values)) if m else float(world.notes["fast"]), world.frequency[place],
    )  # fmt: skip


def _strange(plan: Plan, bench: Bench, drive: Drive, places: list[int], fine: Channels, target: float,
             seed: list[int]) -> tuple[list[Channels], float, float]:  # fmt: skip
    """What the library does not know, of each trial, so large that after the refit it leaves the target."""
    world = bench.world
    act = unknowns.KINDS[plan.effects[0]][2](np.random.default_rng([*seed, 2]))
    conditions, d = bench.plain, world.conditions

    def beside(s: float, drive: Drive, lane: int, place: int, forces: Channels, repeat: int) -> Channels:
        return act(np.random.default_rng([*seed, 3, repeat]), _seen(world, bench, drive, lane, place, forces), s)

    s, size = 0.1, 0.0
    for _ in range(9):
        parts = [beside(s, d, k, k, conditions[k], k) for k in range(d.lanes)]
        r = refit.left(bench.row(parts), bench.J, bench.sd, bench.noise)
        size = max(refit.per_channel(world, conditions, r).values())
        if 0.95 < size / target < 1.05:
            break
        if size < 1e-9:
            s *= 4
            continue
        s *= float(np.clip(target / size, 0.1, 8.0))
    forces = world.samples(fine, drive)
    return [beside(s, drive, k, place, forces[k], 100 + k) for k, place in enumerate(places)], s, size


def _trials(world: World, drive: Drive, places: list[int], fine: Channels, strange: list[Channels] | None, shared: Shared,
            seed: list[int]) -> list[Trial]:  # fmt: skip
    if not world.means:
        return recording.recorded(world, drive, places, fine, strange, shared, [*seed, 4])
    trials = []
    clean = world.samples(fine, drive)
    units = refit.sizes(world, clean)
    for lane, place in enumerate(places):
        rng = np.random.default_rng([*seed, 4, lane])
        true = {n: clean[lane][n] + (strange[lane][n] if strange else 0.0) for n in world.channels}
        out, ideal = {}, {}
        for n in world.channels:
            gain = (1 + shared.gain[n]) * (1 + shared.trial_gain * rng.standard_normal())
            ideal[n] = gain * true[n] + units[n] * shared.zero[n]
            out[n] = ideal[n] + units[n] * shared.noise[n] * recording.noise_of(rng, 1, shared)
        trials.append(Trial(place, np.zeros(1), {}, out, true, ideal, {}))
    return trials


def _coordinates(world: World) -> dict[str, list[Array]]:
    """Every quantity that a box may bound, at the samples of each condition."""
    d, n = world.conditions, world.conditions.lanes
    if world.means:
        return {name: [np.array([d.values[k][name]]) for k in range(n)] for name in world.per_trial}
    columns = {"time": [d.sampled(d.t, k) for k in range(n)]}
    if "slip_velocity" in world.inputs:
        columns["slip_velocity"] = [d.sampled(d.v, k) for k in range(n)]
    if d.load is not None:
        columns["normal_load"] = [d.sampled(d.load, k) for k in range(n)]
    if d.theta is not None and world.inputs:
        theta = [d.sampled(d.theta, k) for k in range(n)]
        columns["contact_temperature" if "contact_temperature" in world.inputs else "proxy_speed"] = (
            [recording.temperature_of(world, q) for q in theta] if "contact_temperature" in world.inputs else theta
        )
    if all(f > 0 for f in world.frequency):
        columns["phase"] = [np.mod(f * d.sampled(d.t, k), 1.0) for k, f in enumerate(world.frequency)]
    return columns | {name: [np.full(d.count[k], d.values[k][name]) for k in range(n)] for name in world.per_trial}


def _everything(world: World) -> dict[str, list[Array]]:
    """These, and what a diagnosis that computes the motion itself may bound besides."""
    columns, d = _coordinates(world), world.conditions
    if world.means:
        return columns
    on = np.ones_like(d.v) if d.held is None else (d.held > 0).astype(float)
    more = {"slip_velocity": d.v * on, "uncut_thickness": d.thickness, "proxy_speed": d.theta, "sliding_distance": d.distance}
    for name, fine in more.items():
        if fine is not None:
            columns.setdefault(name, [d.sampled(fine, k) for k in range(d.lanes)])
    return columns


def _split(world: World, parts: list[Channels], row: Array, unit: Mapping[str, float]) -> list[Channels]:
    """A row of all samples back into the records of the conditions."""
    out: list[Channels] = [{} for _ in parts]
    at = 0
    for name in world.channels:
        for k, part in enumerate(parts):
            out[k][name] = row[at : at + part[name].size] * unit[name]
            at += part[name].size
    return out


def _oracle(world: World, plain: list[Channels], full: list[Channels], refitted: Array, bench: Bench) -> dict[str, Array]:
    """One row for each sample: where it is, and each channel with and without the effects and after the ideal refit."""
    rows: dict[str, list[Array]] = {f"at {name}": parts for name, parts in _everything(world).items()}
    rows["condition"] = [np.full(part[world.channels[0]].size, k + 1.0) for k, part in enumerate(plain)]
    for which, parts in (("without", plain), ("with", full), ("refit", _split(world, plain, refitted, bench.unit))):
        for name in world.channels:
            rows[f"{name} {which}"] = [part[name] for part in parts]
    return {name: np.concatenate(parts) for name, parts in rows.items()}


def _label(plan: Plan, bench: Bench, acting: Acting, full: list[Channels], gap: Array, shared: Shared, trials: list[Trial],
           places: list[int]) -> dict[str, Any]:  # fmt: skip
    """All but the sizes. seen_beside: of each of a pair, what the other leaves of the gap, over the noise."""
    world = bench.world
    parts = _split(world, bench.plain, gap, bench.unit)
    unshared = {n: np.concatenate([_unshared(t, n, shared, bench.unit[n]) for t in trials]) for n in world.channels}
    rms = {n: bench.unit[n] * q for n, q in refit.per_channel(world, bench.plain, gap).items()}
    label: dict[str, Any] = {
        "effects": [e.name for e, _ in acting], "truth": plan.truth, "form": plan.form, "law": plan.law, "cut": plan.cut,
        "law_form": dict(world.law.form), "cut_form": dict(world.cut.form), "stands_for": sorted(catalogue.stands_for(plan.law, plan.cut)),
        "stratum": "-" if plan.truth == "none" else plan.stratum, "kinematics": world.kind, "channels": list(world.channels),
        "causes": [{"name": e.name, "form": e.form, "strength": s} for e, s in acting],
        "families": sorted({catalogue.FAMILY[e.name] for e, _ in acting}), "values": dict(world.params), "gap_rms": rms,
        "gap_over_noise": {n: rms[n] / (bench.unit[n] * shared.noise[n]) for n in world.channels}, "set_up": shared.as_json(),
        "trials": len(trials), "repeats": np.bincount(places).tolist(), "where": [], "places": {}, "seen_beside": {},
        "nominal_effects": list(world.nominal_effects),
        "oracle_rms": {n: float(np.sqrt(np.mean(left**2))) for n, left in unshared.items()},
    }  # fmt: skip
    if acting:
        label["places"] = places_of(world.channels, _coordinates(world), parts)
        label["where"] = [region for ways in label["places"].values() if ways[-1] for region in ways[0]]
    for k, (effect, _) in enumerate(acting if len(acting) > 1 else ()):
        rest = [one for n, one in enumerate(acting) if n != k]
        column = bench.row(world.clean(acting=rest)) - bench.row(bench.plain)
        r = refit.left(
            bench.row(full) - bench.row(bench.plain),
            np.concatenate([bench.J, column[:, None]], axis=1),
            np.append(bench.sd, 1e3),
            bench.noise,
        )
        label["seen_beside"][effect.name] = max(refit.per_channel(world, bench.plain, r).values()) / bench.noise
    return label


def _unshared(trial: Trial, name: str, shared: Shared, unit: float) -> Array:
    """What is left to one who knows the forces and the gain and zero that all trials share."""
    return np.asarray((trial.outputs[name] - shared.zero[name] * unit) / (1 + shared.gain[name]) - trial.true[name])
