"""Which contact, which motions, which conditions? Draws the world of a case whose motion is measured: a friction rig or a machine."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from ellipse import PHASE_X, PHASE_Y, Path, built
from law import Form
from motions import RIG, clock, slow
from radau import Array
from scene import Signal, given
from world import World

Draw = np.random.Generator


@dataclass(frozen=True)
class Setup:
    """A world, and what its owner writes down of it: choices and exact values, how well the rest is known, which signals are inputs."""

    world: World
    exact: dict[str, float | str]
    relative_sd: dict[str, float]
    inputs: tuple[str, ...]
    per_trial: tuple[str, ...] = ()
    notes: dict[str, str] = field(default_factory=dict)


def wrong_form(rng: Draw, chip: bool, typical_h: float = 0.0) -> Form:
    """One or more things that the base law's form has otherwise."""
    every = ["stribeck", "reversal", *(["contact"] if chip else [])]
    kinds = rng.permutation(every)[: int(rng.integers(1, len(every) + 1))]
    stribeck, exponent = [("power", float(rng.uniform(1.1, 1.6))), ("hyperbola", 2.0), ("power", 2.8), ("sech", 1.5)][
        int(rng.integers(0, 4))
    ]
    return Form(
        right=False,
        stribeck=stribeck if "stribeck" in kinds else "gauss",
        exponent=exponent if "stribeck" in kinds else 2.0,
        soft_contact=typical_h * float(rng.uniform(0.02, 0.08)) if "contact" in kinds else 0.0,
        soft_reversal=float(rng.uniform(0.03, 0.15)) if "reversal" in kinds else 0.0,
    )


def _friction_values(rng: Draw, fast: float, stroke: float, flat: bool, dry: bool) -> dict[str, float]:
    F_C = float(np.exp(rng.uniform(np.log(2.0), np.log(40.0))))
    return {
        "F_C": F_C,
        "F_S": F_C * (1.0 if flat else float(rng.uniform(1.12, 1.6))),
        "v_s": fast * float(rng.uniform(0.04, 0.2)),
        "sigma0": F_C / (stroke / float(np.exp(rng.uniform(np.log(4.0), np.log(30.0))))),
        "sigma1": F_C / fast * float(np.exp(rng.uniform(np.log(0.02), np.log(0.25)))),
        "sigma2": 0.0 if dry else F_C / fast * float(rng.uniform(0.08, 0.5)),
    }


def _known(rng: Draw, flat: bool) -> dict[str, float]:
    known = {name: float(np.round(rng.uniform(0.1, 0.25), 2)) for name in ("F_C", "F_S", "v_s", "sigma0", "sigma1", "sigma2")}
    known["sigma1"] = float(np.round(rng.uniform(0.2, 0.4), 2))
    known["v_s"] = float(np.round(rng.uniform(0.15, 0.3), 2))
    if flat:
        known |= {"F_S": 0.03, "F_C": float(np.round(rng.uniform(0.02, 0.05), 3))}
    return known


def _temperature(theta: Signal, exact: dict[str, float | str]) -> Signal:
    """The temperature whose proxy, by the component's own rule, is theta."""
    low, high = float(exact["ambient_temperature"]), float(exact["reference_temperature"])
    return lambda t: low + (high - low) * (theta(t) / float(exact["theta_ref"])) ** float(exact["alpha_T"])


def rig(rng: Draw, wrong: bool, *, flat: bool = False, dry: bool = False, needs: tuple[str, ...] = (), rests: bool = False) -> Setup:
    """A friction rig: slip velocity in, friction force out, perhaps temperature and load. flat: no static peak; dry: no viscous part."""
    kind = "stepped" if rests else str(rng.choice(list(RIG)))
    frequency = float(np.exp(rng.uniform(np.log(1.0), np.log(60.0))))
    fast = float(np.exp(rng.uniform(np.log(2e-3), np.log(0.25))))
    count = int(rng.integers(3, 8 if kind != "stepped" else 6))
    values = _friction_values(rng, fast, fast / (2 * np.pi * frequency), flat, dry)
    hot = "theta" in needs or rng.random() < 0.5
    loaded = "load" in needs or rng.random() < 0.4
    by_temperature = hot and rng.random() < 0.35
    exact: dict[str, float | str] = {}
    if hot:
        exact |= {"theta_ref": float(f"{0.5 * fast:.2g}"), "proxy_source": "contact_temperature" if by_temperature else "proxy_speed"}
    if by_temperature:
        exact |= {"ambient_temperature": 293.15, "reference_temperature": 393.15, "alpha_T": 0.5}
    shares = rng.permutation(np.linspace(0.2, 1.0, count))
    tempi = rng.permutation(np.geomspace(0.6, 1.7, count))
    scenes, excitation = [], []
    motion_seed = int(rng.integers(1 << 30))
    for n in range(count):
        own = np.random.default_rng([motion_seed, n if kind == "stepped" else 0])
        motion = RIG[kind](own, frequency * float(tempi[n]), 0.45 if rests else 0.2)
        peak, span = fast * float(shares[n]), float(motion.times[-1])
        signals: dict[str, Signal] = {"slip_velocity": lambda t, peak=peak, motion=motion: peak * motion.slip(t)}  # type: ignore[misc]
        theta = None
        if hot:
            theta = slow(rng, span, fast * float(rng.uniform(0.2, 0.9)), float(rng.uniform(0.15, 0.6)))
            signals["contact_temperature" if by_temperature else "proxy_speed"] = _temperature(theta, exact) if by_temperature else theta
        if loaded:
            signals["normal_load"] = slow(rng, span, float(10 * rng.uniform(0.4, 1.7)), float(rng.uniform(0.05, 0.4)))
        fastest = 8 if kind != "multi_sine" else 5
        scenes.append(given(motion.times, fastest, signals, {}, theta))
        excitation.append(motion.frequency)
    form = wrong_form(rng, chip=False) if wrong else Form()
    world = World("rig/" + kind, tuple(scenes), ("friction_force",), values, form, excitation=tuple(excitation))
    inputs = tuple(scenes[0].signals)
    return Setup(world, exact, _known(rng, flat), inputs)


def machine(rng: Draw, wrong: bool, *, flat: bool = False, dry: bool = False, needs: tuple[str, ...] = ()) -> Setup:
    """A machine at ultrasonic rates whose slip and thickness are known: three forces out."""
    frequency = float(rng.choice([18e3, 20e3, 25e3, 40e3]))
    fast = float(rng.uniform(0.15, 0.7))
    count = int(rng.integers(3, 6))
    values = _friction_values(rng, fast, fast / (2 * np.pi * frequency), flat, dry)
    values |= {"shear_stress": float(rng.uniform(2e8, 8e8))}
    width = float(np.round(rng.uniform(0.5e-3, 2e-3), 4))
    thick = values["F_C"] / (values["shear_stress"] * width) * float(rng.uniform(0.6, 2.5))
    exact: dict[str, float | str] = {
        "width": width, "rake_angle": float(np.round(rng.choice([0.0, 0.0, -0.1, 0.1, 0.15]), 3)),
        "shear_angle_principle": str(rng.choice(["maximum_shear_stress", "minimum_energy"])),
    }  # fmt: skip
    values |= {"width": width, "rake_angle": float(exact["rake_angle"])}
    hot = "theta" in needs or rng.random() < 0.5
    loaded = "load" in needs or rng.random() < 0.3
    if hot:
        exact |= {"theta_ref": float(f"{0.5 * fast:.2g}"), "proxy_source": "proxy_speed"}
    interrupted = rng.random() < 0.5
    scenes, omega = [], 2 * np.pi * frequency
    cycles, per = int(rng.integers(14, 30)), int(rng.integers(60, 100))
    for _ in range(count):
        peak, mean = fast * float(rng.uniform(0.4, 1.0)), fast * float(rng.uniform(-0.1, 0.5))
        level, swing = thick * float(rng.uniform(0.5, 1.5)), float(rng.uniform(1.05, 1.6)) if interrupted else float(rng.uniform(0.2, 0.8))
        lead = float(rng.uniform(0.6, 2.2))
        times = clock(cycles / frequency, cycles * per)

        def slip(t: Array, peak: float = peak, mean: float = mean, lead: float = lead) -> Array:
            return mean + peak * np.sin(omega * t - lead)

        def chip(t: Array, level: float = level, swing: float = swing) -> Array:
            return level * (1 - swing * np.cos(omega * t))

        signals: dict[str, Signal] = {"slip_velocity": slip, "uncut_thickness": chip}
        theta = None
        if hot:
            theta = slow(rng, float(times[-1]), fast * float(rng.uniform(0.2, 0.9)), float(rng.uniform(0.15, 0.6)))
            signals["proxy_speed"] = theta
        if loaded:
            signals["normal_load"] = slow(rng, float(times[-1]), float(10 * rng.uniform(0.4, 1.7)), float(rng.uniform(0.05, 0.4)))
        scenes.append(given(times, 8, signals, {}, theta))
    form = wrong_form(rng, chip=interrupted, typical_h=thick) if wrong else Form()
    channels = ("friction_force", "principal_force", "feed_force") if rng.random() < 0.6 else ("principal_force", "feed_force")
    world = World(
        "machine", tuple(scenes), channels, values, form, principle=str(exact["shear_angle_principle"]), excitation=(frequency,) * count
    )
    known = _known(rng, flat) | {"shear_stress": float(np.round(rng.uniform(0.05, 0.15), 2)), "width": 0.0, "rake_angle": 0.0}
    return Setup(world, exact, known, tuple(scenes[0].signals))


def _process(rng: Draw, frequency: float) -> tuple[dict[str, float], dict[str, float]]:
    """Values of an elliptical vibration cut: those of the process, and those of friction and material."""
    process = {
        "vibration_frequency": frequency,
        "amplitude_x": float(np.round(rng.uniform(3e-6, 1.2e-5), 7)),
        "amplitude_y": float(np.round(rng.uniform(3e-6, 1.0e-5), 7)),
        "width": float(np.round(rng.uniform(0.5e-3, 2e-3), 4)),
        "rake_angle": float(np.round(rng.choice([0.0, 0.0, -0.1, 0.1]), 3)),
        "chip_flow_shear_angle": float(np.round(rng.uniform(0.4, 0.75), 3)),
    }
    shallow = rng.random() < 0.8  # the cut ends within the surface that the cycle before has left: no step of the thickness
    thick = process["amplitude_y"] * (rng.uniform(0.25, 0.6) if shallow else rng.uniform(1.5, 5.0))
    process = {**process, "feed": float(np.round(thick, 8))}
    fast = 2 * np.pi * frequency * process["amplitude_y"]
    values = _friction_values(rng, fast, process["amplitude_y"], False, False)
    values["shear_stress"] = float(rng.uniform(2e8, 8e8))
    shear = values["shear_stress"] * process["width"] * process["feed"]
    scale = shear * float(rng.uniform(0.25, 1.0)) / values["F_C"]
    return process, {name: value * (scale if name not in ("v_s", "shear_stress") else 1.0) for name, value in values.items()}


def turning(rng: Draw, wrong: bool, *, flat: bool = False, dry: bool = False, needs: tuple[str, ...] = (), slow_tool: bool = False,
            means: bool = False) -> Setup:  # fmt: skip
    """Elliptical vibration assisted turning at several cutting speeds: records of some tens of cycles, or averages over many conditions."""
    frequency = float(rng.choice([200.0, 500.0, 1000.0, 2000.0] if slow_tool else [17e3, 20e3, 25e3, 32e3, 40e3]))
    process, values = _process(rng, frequency)
    if flat:
        values["F_S"] = values["F_C"]
    if dry:
        values["sigma2"] = 0.0
    values |= process
    principle = str(rng.choice(["maximum_shear_stress", "minimum_energy"]))
    exact: dict[str, float | str] = {**process, "shear_angle_principle": principle, "phase_x": float(PHASE_X), "phase_y": float(PHASE_Y)}
    limit = 2 * np.pi * frequency * process["amplitude_x"]
    count = int(rng.integers(9, 17)) if means else int(rng.integers(3, 7))
    ratios = np.exp(rng.uniform(np.log(0.05), np.log(0.75), count)) if means else rng.permutation(np.geomspace(0.07, 0.6, count))
    source = "cutting_speed" if "theta" in needs or rng.random() < 0.5 else "slip_speed"
    signal_given = not means and source == "cutting_speed" and rng.random() < 0.4
    if source == "cutting_speed":
        exact |= {"proxy_source": "proxy_speed" if signal_given else "cutting_speed", "theta_ref": float(f"{0.3 * limit:.2g}")}
    feeds = np.exp(rng.uniform(np.log(0.5), np.log(1.5), count)) if means or rng.random() < 0.4 else np.ones(count)
    sizes = rng.uniform(0.7, 1.3, count) if means and rng.random() < 0.5 else np.ones(count)
    per_trial = ("cutting_speed", *(["feed"] if np.ptp(feeds) > 0 else []), *(["amplitude_y"] if np.ptp(sizes) > 0 else []))
    cycles, per = int(rng.integers(16, 36)), int(rng.integers(44, 100))
    scenes = []
    for ratio, thick, big in zip(ratios, feeds, sizes, strict=True):
        run = {"cutting_speed": ratio * limit, "feed": process["feed"] * thick, "amplitude_y": process["amplitude_y"] * big}
        run = {name: float(f"{run[name]:.5g}") for name in per_trial}
        times = clock(cycles / frequency, cycles * per) + 0.5 / frequency
        if means:
            times = (0.5 + np.arange(401) / 400) / frequency
        theta, signals = None, {}
        if signal_given:
            theta = slow(rng, float(times[-1]), limit * float(rng.uniform(0.1, 0.5)), float(rng.uniform(0.15, 0.6)))
            signals = {"proxy_speed": theta}
        path = Path({**values, **run})
        scenes.append(built(path, times, 30 if means else 8, signals, run, theta, principle, source))
    form = wrong_form(rng, chip=True, typical_h=process["feed"]) if wrong else Form()
    channels: tuple[str, ...] = ("mean_principal_force", "mean_feed_force") if means else ("principal_force", "feed_force")
    if not means and rng.random() < 0.3:
        channels = ("friction_force", *channels)
    world = World(
        "means" if means else "ellipse",
        tuple(scenes),
        channels,
        values,
        form,
        principle=principle,
        means=means,
        excitation=(frequency,) * count,
    )
    known = _known(rng, flat) | {"shear_stress": float(np.round(rng.uniform(0.05, 0.15), 2))} | dict.fromkeys(process, 0.0)
    if means:
        known |= {
            name: float(np.round(rng.uniform(0.04, 0.1), 2)) for name in ("F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s", "shear_stress")
        }
        known["F_S"] = 0.02 if flat else known["F_S"]
    return Setup(world, exact, known, tuple(scenes[0].signals), per_trial)
