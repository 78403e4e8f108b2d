"""What is the truth of a case? Draws its world, its cause and size, its noise and its nominal model, and writes down what was drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import rigs
from causes_cut import CUT
from causes_friction import FRICTION
from causes_sensor import SENSOR
from ellipse import PATH
from label import free_values, hold_of, label_of
from law import Form
from noise import Noise, usual
from refit import Refit, difference, flatten, jacobian, left_by, projected, refit, size
from rigs import Setup
from strangers import FOR_MEANS, STRANGERS, Stranger
from world import Acting, Cause, Channels, World

Draw = np.random.Generator
Maker = Callable[[World, Draw], Cause]

CAUSES: dict[str, Maker] = {**FRICTION, **CUT, **SENSOR, **PATH}
STRATA = {"low": 1.5, "middle": 4.0, "high": 12.0}  # rms of the gap after the ideal refit, over the rms of the noise
GAPS = {"low": (0.012, 0.04), "middle": (0.02, 0.08), "high": (0.04, 0.15)}  # of the rms of the force
FORM_GAP = (0.4, 3.0)  # rms that a wrong form leaves after its refit, over the rms of the noise

RIG_CAUSES = (
    "thermal_softening", "thermal_damping", "thermal_viscosity", "direction_asymmetry", "load_dependence", "viscous_friction", "stribeck",
    "elasto_plastic", "dwell_strengthening", "friction_wear", "proxy_lag", "sensor_delay", "sensor_offset", "sensor_drift",
    "sensor_lowpass", "dynamometer_resonance",
)  # fmt: skip
MACHINE_CAUSES = (
    "thermal_softening", "direction_asymmetry", "load_dependence", "viscous_friction", "elasto_plastic", "friction_wear", "size_effect",
    "flow_stress_softening", "edge_force", "flank_wear", "sensor_delay", "sensor_gain", "sensor_offset", "sensor_drift", "cross_talk",
    "sensor_lowpass", "dynamometer_resonance",
)  # fmt: skip
ELLIPSE_CAUSES = (
    *MACHINE_CAUSES, "thermal_viscosity", "stribeck", "process_damping", "ellipse_phase_error", "run_out", "amplitude_loss",
    "holder_compliance",
)  # fmt: skip
MEANS_CAUSES = (
    "thermal_softening", "direction_asymmetry", "load_dependence", "viscous_friction", "size_effect", "flow_stress_softening", "edge_force",
    "process_damping", "amplitude_loss", "ellipse_phase_error", "sensor_gain", "sensor_offset", "cross_talk",
)  # fmt: skip
BY_KIND = {"rig": RIG_CAUSES, "machine": MACHINE_CAUSES, "ellipse": ELLIPSE_CAUSES, "means": MEANS_CAUSES}
THERMAL = ("thermal_softening", "thermal_damping", "thermal_viscosity", "flow_stress_softening", "proxy_lag")
RIVALS = ({"edge_force", "size_effect"}, {"thermal_softening", "proxy_lag"})  # the second: a lag needs a nominal model that has softening


class NotDrawn(Exception):
    """These draws make no case: the cause has no say here, or not enough."""


@dataclass(frozen=True)
class Case:
    """All of one case. recorded: condition, place of its scene, channels; clean: with and without the causes, and the ideal refit."""

    setup: Setup
    nominal: dict[str, float]
    recorded: list[tuple[str, int, Channels]]
    clean: dict[str, list[Channels]]
    label: dict[str, Any]


@dataclass(frozen=True)
class Bench:
    """What every step of a draw needs: the world, its forces without a cause and their sizes, and what a refit could do."""

    world: World
    plain: list[Channels]
    weight: dict[str, float]
    hold: dict[str, float]
    J: Any
    noise: float  # rms aimed at, of the forces

    def left(self, forces: list[Channels], beside: list[Channels] | None = None) -> float:
        cling = np.array([self.hold[name] for name in self.hold if self.world.values[name] > 0])
        return left_by(self.world, forces, beside or self.plain, self.weight, self.J, cling)


def bench(setup: Setup, noise: float, form: Form | None = None) -> Bench:
    world = setup.world if form is None else replace(setup.world, form=form)
    plain = world.respond()
    weight = size(world, plain)
    if min(weight.values()) <= 0 or not all(np.isfinite(list(weight.values()))):
        raise NotDrawn("a channel shows nothing")
    hold = hold_of(setup, noise)
    _, J = jacobian(world, dict(world.values), list(hold), weight, world.form)
    return Bench(world, plain, weight, hold, J, noise)


def setup_for(kind: str, names: tuple[str, ...], rng: Draw, wrong: bool) -> Setup:
    """A world in which all these causes could act. What one of them needs, others have at times, too."""
    needs = tuple(n for n, wanted in (("theta", THERMAL), ("load", ("load_dependence",))) if set(names) & set(wanted))
    flat = "stribeck" in names or rng.random() < 0.15
    dry = "viscous_friction" in names or ("thermal_viscosity" not in names and rng.random() < 0.15)
    if kind in ("ellipse", "means"):
        return rounded(rigs.turning(rng, wrong, flat=flat, dry=dry, needs=needs, slow_tool=rng.random() < 0.25, means=kind == "means"))
    lagging = "proxy_lag" in names or ("thermal_softening" not in names and rng.random() < 0.1)
    if lagging:
        needs = tuple(dict.fromkeys([*needs, "theta"]))
    if kind == "rig":
        setup = rigs.rig(rng, wrong, flat=flat, dry=dry, needs=needs, rests="dwell_strengthening" in names)
    else:
        setup = rigs.machine(rng, wrong, flat=flat, dry=dry, needs=needs)
    return rounded(with_softening(setup, rng) if lagging else setup)


def with_softening(setup: Setup, rng: Draw) -> Setup:
    """The same with a nominal model that softens with temperature already."""
    world = setup.world
    hot = float(np.quantile(np.concatenate([scene.theta[:, 1] for scene in world.scenes]), 0.9))
    Q, theta_ref = float(np.round(rng.uniform(0.6, 1.6), 2)), float(setup.exact["theta_ref"])
    k_Q = float(world.values["sigma0"] * rng.uniform(0.2, 0.4) / (hot / theta_ref) ** Q)
    values = {**world.values, "theta_ref": theta_ref, "thermal_softening.k_Q": k_Q, "thermal_softening.Q": Q}
    return replace(
        setup, world=replace(world, values=values, nominal_effects=("thermal_softening",)), exact={**setup.exact, "thermal_softening.Q": Q},
        relative_sd={**setup.relative_sd, "thermal_softening.k_Q": 0.1},
    )  # fmt: skip


def rounded(setup: Setup) -> Setup:
    """The truth to four digits, so that a nominal value can be exactly right; exact values as they are."""
    values = {name: value if name in setup.exact else float(f"{value:.4g}") for name, value in setup.world.values.items()}
    return replace(setup, world=replace(setup.world, values=values))


def fit_form(setup: Setup, noise: float, rng: Draw) -> Setup:
    """A wrong form brought so near to the right one that its own gap is of the noise's order: what a careful user might not know."""
    wanted = noise * float(np.exp(rng.uniform(*np.log(FORM_GAP))))
    right, form = bench(setup, noise, Form()), setup.world.form
    for _ in range(3):
        left = right.left(replace(setup.world, form=form).respond())
        if left <= 1e-3 * wanted:
            raise NotDrawn("this form shows nothing")
        most = min(1.3 / form.blend, 0.4 / max(form.soft_reversal, 1e-9))
        form = form.scaled(float(np.clip(wanted / left, 0.05, min(most, 5.0))))
    return replace(setup, world=replace(setup.world, form=form))


def sized(on: Bench, cause: Cause, target: float, rng: Draw, others: Acting = ()) -> float:
    """The strength at which the cause leaves a relative gap of the target, beside others that act already."""
    base = on.world.respond(causes=others) if others else on.plain
    sign = float(rng.choice([-1, 1])) if cause.both_ways else 1.0
    s, leaves = cause.typical, 0.0
    for _ in range(5):
        leaves = on.left(on.world.respond(causes=[*others, (cause, sign * s)]), base)
        if not np.isfinite(leaves) or leaves < 1e-7:
            raise NotDrawn(f"{cause.name} has no say")
        if 0.8 < leaves / target < 1.25 or (s >= cause.most and leaves < target):
            break
        s = float(np.clip(s * np.clip(target / leaves, 0.1, 6.0), max(1e-3 * cause.most, cause.least), cause.most))
    if s < 0.99 * cause.least:
        raise NotDrawn(f"{cause.name} would be too fine for the clock")
    if leaves < 0.3 * target or leaves > 3 * target:
        raise NotDrawn(f"{cause.name} leaves {leaves:.2g}, not {target:.2g}")
    return sign * s


def draw_case(kind: str, truth: str, names: tuple[str, ...], stratum: str, wrong: bool, rng: Draw) -> Case:
    """One case of this kind, truth, causes, stratum and form; NotDrawn where it does not come off."""
    named = truth in ("single", "pair")
    target = float(np.exp(rng.uniform(*np.log(GAPS[stratum]))))
    setup = setup_for(kind, names if named else (), rng, wrong)
    if wrong:
        setup = fit_form(setup, target / STRATA[stratum], rng)
    on = bench(setup, target / STRATA[stratum])
    world = setup.world
    acting: list[tuple[Cause, float]] = []
    shares = [1.0, float(rng.choice([0.1, 0.4, 0.6, 0.8, 1.0], p=[0.15, 0.2, 0.25, 0.2, 0.2]))]
    for name, share in zip(names if named else (), shares, strict=False):
        cause = CAUSES[name](world, rng)
        acting.append((cause, sized(on, cause, share * target, rng, acting)))
    stranger = (FOR_MEANS if world.means else STRANGERS)[names[0]](world, rng) if truth == "unknown" else None
    nominal = dict(world.values) if truth == "none" else off(setup, rng, strong=truth == "mistuned")
    total = sum(scene.times.size for scene in world.scenes)
    repeats = max(2, min(int(rng.integers(2, 5)), 80_000 // (total * len(world.channels))))
    full = world.respond(causes=acting)
    fitted = refit(world, full, on.hold, on.weight)
    noise, strange = noise_for(on, truth, STRATA[stratum], target, full, fitted, nominal, stranger, rng)
    recorded = record(world, full, noise, repeats, stranger, strange, rng)
    label = {
        "truth": truth, "stratum": stratum, "ratio": STRATA[stratum], "nominal": nominal, "repeats": repeats, "noise": asdict(noise),
        "unknown": {"kind": names[0], "size": strange} if stranger else None,
        "oracle_rms": oracle_rms(world, full, recorded), "nominal_gap_rms": size(world, difference(full, world.respond(nominal))),
        **label_of(setup, acting, noise, fitted, repeats, on.plain, nominal, others(setup, acting)),
    }  # fmt: skip
    if wrong:
        label["form_gap_rms"] = refit(world, on.plain, on.hold, on.weight, form=Form()).size
        most = max(label["form_gap_rms"][name] / noise.rms[name] for name in world.channels)
        if not FORM_GAP[0] / 4 < most < FORM_GAP[1] * 2:
            raise NotDrawn(f"the form leaves {most:.2g} of the noise")
    return Case(setup, nominal, recorded, {"with": full, "without": on.plain, "refit": difference(full, fitted.gap)}, label)


def others(setup: Setup, acting: Acting) -> dict[str, list[Cause]]:
    """All other causes that could be claimed of a single one's case, in two draws of their forms."""
    if len(acting) != 1:
        return {}
    names = [name for name in BY_KIND[setup.world.kind.split("/")[0]] if name != acting[0][0].name and possible(setup, name)]
    return {name: [CAUSES[name](setup.world, np.random.default_rng(seed)) for seed in range(2)] for name in names}


def off(setup: Setup, rng: Draw, *, strong: bool) -> dict[str, float]:
    """What the owner believes: some values 5 to 40 % off, by no more than 2.2 of the standard deviations told; or all a little."""
    truth, free = setup.world.values, free_values(setup)
    believed = dict(truth)
    hit = set(rng.permutation(free)[: int(rng.integers(1, 4))].tolist())
    for name in free:
        sd = setup.relative_sd[name]
        if strong and name not in hit:
            continue
        shift = (
            float(rng.choice([-1, 1])) * float(np.clip(rng.uniform(0.8, 2.2) * sd, 0.05, 0.4))
            if strong
            else float(rng.uniform(-0.6, 0.6)) * sd
        )
        believed[name] = float(f"{truth[name] * (1 + shift):.4g}")
    return believed


def noise_for(on: Bench, truth: str, ratio: float, target: float, full: list[Channels], fitted: Refit, nominal: dict[str, float],
              stranger: Stranger | None, rng: Draw) -> tuple[Noise, float]:  # fmt: skip
    """Noise that puts the gap into its stratum, and the size of what the library does not know."""
    world, weight, strange, rms = on.world, on.weight, 0.0, target / ratio
    spread = {name: float(rng.uniform(0.7, 1.3)) for name in world.channels}
    if truth in ("single", "pair"):
        rms = max(fitted.size[name] / (weight[name] * spread[name]) for name in world.channels) / ratio
    elif truth == "mistuned":
        gap = size(world, difference(full, world.respond(nominal)))
        rms = max(gap[name] / (weight[name] * spread[name]) for name in world.channels) / ratio
    elif stranger is not None:
        unit = [stranger(np.random.default_rng(7), scene, part) for scene, part in zip(world.scenes, on.plain, strict=True)]
        left = projected(flatten(world, unit, weight), on.J)
        strange = target / max(float(np.sqrt(np.mean(left**2))), 1e-9)
    if not (3e-4 <= rms <= 0.08 and 1 / 3 < rms / on.noise < 3):
        raise NotDrawn(f"noise of {rms:.2g} of the force")
    return usual(rng, world, full, {name: rms * weight[name] * spread[name] for name in world.channels}), strange


def record(world: World, full: list[Channels], noise: Noise, repeats: int, stranger: Stranger | None, strange: float,
           rng: Draw) -> list[tuple[str, int, Channels]]:  # fmt: skip
    """What the owner has: every condition `repeats` times; of averages the mean of the repeats and its standard deviation."""
    recordings = []
    for place, (scene, clean) in enumerate(zip(world.scenes, full, strict=True)):
        repeated = []
        for _ in range(repeats):
            forces = dict(clean)
            if stranger is not None:
                more = stranger(rng, scene, clean)
                forces = {name: force + strange * more[name] for name, force in forces.items()}
            repeated.append(noise.spoil(rng, scene.times, forces))
        name = f"c{place + 1}"
        if world.means:
            recordings.append((name, place, averaged(world.channels, clean, repeated, noise)))
        else:
            recordings += [(name, place, one) for one in repeated]
    return recordings


def oracle_rms(world: World, full: list[Channels], recorded: list[tuple[str, int, Channels]]) -> dict[str, float]:
    """What one who knows the truth to the last digit, but no trial's noise, would leave."""
    return {
        name: float(np.sqrt(np.mean(np.concatenate([forces[name] - full[place][name] for _, place, forces in recorded]) ** 2)))
        for name in world.channels
    }


def averaged(channels: Sequence[str], clean: Channels, repeated: list[Channels], noise: Noise) -> Channels:
    row: Channels = {}
    for channel in channels:
        parts = (noise.rms[channel], noise.jitter[f"zero {channel}"], noise.jitter["gain"] * float(clean[channel][0]))
        row[channel] = np.array([np.mean([one[channel][0] for one in repeated])])
        row[channel + "_sd"] = np.array([float(np.linalg.norm(parts)) / np.sqrt(len(repeated))])
    return row


def possible(setup: Setup, name: str) -> bool:
    """Whether a cause could be claimed in this setup at all."""
    world = setup.world
    if name in THERMAL and setup.exact.get("proxy_source", "slip_speed") == "slip_speed":
        return False
    if name == "load_dependence" and world.kind not in ("ellipse", "means") and "normal_load" not in setup.inputs:
        return False
    if name in world.nominal_effects or (name == "proxy_lag" and not world.nominal_effects):
        return False
    return not (name == "thermal_viscosity" and world.values["sigma2"] == 0)
