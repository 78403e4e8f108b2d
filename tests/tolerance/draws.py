"""Which contacts and motions is the kernel judged on? Seeded draws: draw number n of seed s is always the same case.

Laws, effects and parameters are asked of the kernel's tables, so that a new one is drawn without a line here. What is not drawn, and why:
averaging = cycle: it claims a mean, not the resolved run; tests/laws/test_averaging.py judges it. chip_flow_angle = current_shear_angle
with bristle, karnopp and reset_integrator: their events are acted upon at the ends of the kernel's steps, whatever these are. bristle with
load_dependence or sticking_limit: bonds break without end where the load vanishes, and where the next ones form hangs on roundings. A
periodic start where nothing relaxes (bristle, reset_integrator, and the effects of STAYS): more than one cycle comes back to itself.
"""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from evat import parameter_sets
from evat.model import Effect, FloatArray, Variable
from evat.native import kernel
from judged import Case, Motion

GIVEN = ("ramp", "stop", "stop_and_go", "reversal", "plateau", "held", "triangle", "sine")
VIBRATING = ("ellipse", "combined")
LAWS = {"lugre": 0.45, "dahl": 0.11, "coulomb": 0.07, "karnopp": 0.11, "bristle": 0.11, "reset_integrator": 0.11, "amontons": 0.04}
TOLERANCES = {1e-3: 0.1, 1e-4: 0.5, 1e-5: 0.3, 1e-6: 0.1}
PATH_ONLY = ("amplitude_loss", "ellipse_phase_error", "process_damping")  # they say nothing where slip and thickness are given
EVENTFUL = ("bristle", "karnopp", "reset_integrator")
LOADED = ("load_dependence", "sticking_limit")  # friction vanishes with the load
STAYS = ("elasto_plastic", "maxwell_slip", "position_dependence", "backlash")  # where it was led
Random = np.random.Generator


def draw(seed: int, number: int) -> Case:
    """One case."""
    random = np.random.default_rng([seed, number])
    vibrating = bool(random.uniform() < 0.3)
    kind = str(random.choice(VIBRATING, p=[0.7, 0.3]) if vibrating else random.choice(GIVEN))
    values: dict[str, Any] = {"kinematics": "external", "friction_law": _choice(random, LAWS), **friction(random)}
    if vibrating:
        values["kinematics"] = "internal" if kind == "ellipse" else "combined"
        values |= ellipse(random)
    effects = [
        effect for effect in switched(random, vibrating=vibrating) if values["friction_law"] != "bristle" or effect.name not in LOADED
    ]
    on = tuple(effect.name for effect in effects)
    if vibrating and values["friction_law"] == "bristle":  # each bond breaks, and each break is an event: not too many in a cycle
        level, path = float(values.get("F_C", kernel.variable("F_C").start)), 4 * (values["amplitude_x"] + values["amplitude_y"])
        values["sigma0"] = min(float(values.get("sigma0", kernel.variable("sigma0").start)), 3 * level * 8 / path)
    if vibrating and values["friction_law"] not in EVENTFUL and random.uniform() < 0.1:
        values["chip_flow_angle"] = "current_shear_angle"
    values |= _process(random, on)
    motion = vibration(random, kind, values) if vibrating else slip(random, kind, values, _duration(random, effects, values))
    for effect in effects:
        values |= parameters(random, effect, float(motion.times[-1]), values)
    if motion.stepped and "input_delay" in on:  # a host knows nothing of what comes
        values["input_delay.time"] = abs(values["input_delay.time"])
    many = values["friction_law"] in ("bristle", "reset_integrator") or any(name in on for name in STAYS)
    if many or "sensor_delay" in on or "regenerative" in on:  # more than one cycle comes back to itself, or what was before it is none
        values.pop("initial_state", None)
    if random.uniform() < 0.2 and not vibrating:
        values["averaging_window"] = float(motion.times[-1]) * random.uniform(0.05, 0.6)
    return Case(kind, values, on, motion, float(_choice(random, TOLERANCES)), (seed, number))


def _choice(random: Random, shares: Mapping[Any, float]) -> Any:
    return list(shares)[random.choice(len(shares), p=list(shares.values()))]


def logarithmic(random: Random, low: float, high: float) -> float:
    return float(10 ** random.uniform(math.log10(low), math.log10(high)))


# ---- the contact ----


@functools.cache
def shipped() -> tuple[Mapping[str, float], ...]:
    """The values of the shipped parameter sets; those of effects are drawn."""
    own = {name for effect in kernel.effects() for name in (effect.name, *(variable.name for variable in effect.variables))}
    sets = (parameter_sets.load(name).values for name in parameter_sets.names())
    return tuple({name: value for name, value in values.items() if name not in own} for values in sets)


def friction(random: Random) -> dict[str, Any]:
    """As the component starts, as a shipped set has it, or anything plausible."""
    kind = random.choice(3, p=[0.25, 0.25, 0.5])
    values: dict[str, Any] = {}
    if kind == 1:
        values = dict(shipped()[random.integers(len(shipped()))])
    elif kind == 2:
        level = logarithmic(random, 0.5, 20)
        values = {
            "sigma0": logarithmic(random, 1e5, 1e7),
            "sigma1": logarithmic(random, 1, 1e3),
            "sigma2": random.choice([0, 1]) * random.uniform(0, 2),
            "F_C": level,
            "F_S": level * random.uniform(0.5, 2),
            "v_s": logarithmic(random, 5e-4, 5e-2),
            "damping_mode": "dissipative" if random.uniform() < 0.85 else "as_published",
        }
    if random.uniform() < 0.2:
        values["lugre.stribeck_exponent"] = float(random.choice([0.5, 1, 1.5, 3])) if random.uniform() < 0.5 else random.uniform(0.3, 6)
    if random.uniform() < 0.2:
        values["lugre.presliding_exponent"] = random.uniform(0.5, 4)
        values["lugre.viscous_exponent"] = random.uniform(0.4, 2)
    values["karnopp.zero_velocity_band"] = logarithmic(random, 1e-4, 1e-2)
    values["bristle.seed"] = float(random.integers(1000))
    return values


def _process(random: Random, on: Sequence[str]) -> dict[str, Any]:
    """What is there beside friction."""
    values: dict[str, Any] = {}
    if random.uniform() < 0.3:
        values["shear_angle_principle"] = "minimum_energy"
    if random.uniform() < 0.3:
        values["rake_angle"] = random.uniform(-0.2, 0.2)
    if random.uniform() < 0.3:
        values["release_time"] = logarithmic(random, 1e-6, 1e-3)
    if random.uniform() < 0.5 and any("proxy_speed" in effect.needs for effect in kernel.effects() if effect.name in on):
        values["proxy_source"] = str(random.choice(["proxy_speed", "cutting_speed", "contact_temperature"]))
    if random.uniform() < 0.1:
        values["rate_stiffness"] = "thermal"
    return values


# ---- effects ----


def switched(random: Random, *, vibrating: bool) -> list[Effect]:
    """None, one or two that may go together."""
    open_to = [effect for effect in kernel.effects() if vibrating or effect.name not in PATH_ONLY]
    on: list[Effect] = []
    for _ in range(random.choice(3, p=[0.35, 0.4, 0.25])):
        effect = open_to[random.integers(len(open_to))]
        if effect not in on and not any(effect.name in other.rivals or other.name in effect.rivals for other in on):
            on.append(effect)
    return sorted(on, key=lambda effect: kernel.variable(effect.name).index)


def parameters(random: Random, effect: Effect, duration: float, values: Mapping[str, Any]) -> dict[str, float]:
    """Near their starts; times in half of the draws such that the motion shows them."""
    period = 1 / float(values["vibration_frequency"]) if "vibration_frequency" in values else duration / 10
    drawn = {variable.name: _near(random, variable) for variable in effect.variables}
    seen: dict[str, float] = {
        "input_delay.time": period * random.uniform(-0.5, 0.4),
        "sensor_delay.time": period * random.uniform(0.02, 1.5),
        "sensor_lowpass.time_constant": period * logarithmic(random, 0.01, 3),
        "dynamometer_resonance.natural_period": period * logarithmic(random, 0.2, 3),
        "proxy_lag.time_constant": period * logarithmic(random, 0.05, 10),
        "run_out.spindle_frequency": min(random.uniform(0.5, 3) / duration, 1e4),
        "line_disturbance.frequency": min(random.uniform(0.5, 30) / duration, 1e5),
        "friction_wear.s_0": logarithmic(random, 1e-5, 1),
        "backlash.gap": logarithmic(random, 1e-6, 1e-3),
        "position_dependence.period": logarithmic(random, 1e-5, 1e-2),
        "maxwell_slip.stroke": logarithmic(random, 1e-6, 1e-3),
        "rate_and_state.d_c": logarithmic(random, 1e-6, 1e-2),
        "dwell_strengthening.t_ref": duration * logarithmic(random, 1e-4, 1),
        "amplitude_loss.response_time": max(period * logarithmic(random, 0.3, 10), 1e-6),
        "regenerative.revolution_time": max(duration * random.uniform(0.15, 0.6), 1e-5),
    }
    shown = random.uniform() < 0.5
    for name, value in seen.items():
        if name in drawn and (shown or name == "regenerative.revolution_time"):
            drawn[name] = value
    if "dynamometer_resonance.natural_period" in drawn:  # no more swings than can be followed
        drawn["dynamometer_resonance.natural_period"] = min(max(drawn["dynamometer_resonance.natural_period"], duration / 300), 1)
    if "flank_wear.break_in" in drawn and shown:
        drawn["flank_wear.break_in"] = logarithmic(random, 1e-5, 1)
    return drawn


def _near(random: Random, variable: Variable) -> float:
    if variable.start == 0:
        reach = min(abs(variable.min), abs(variable.max), 1e3)
        return max(random.uniform(-0.3, 0.3) * reach, variable.min)
    if variable.start == 1 and variable.max == 1:  # a share
        return random.uniform(0.2, 1)
    value = variable.start * math.exp(random.normal(0, 0.7))
    return float(min(max(value, variable.min), variable.max))


def _duration(random: Random, effects: Sequence[Effect], values: dict[str, Any]) -> float | None:
    """A short motion where something swings fast."""
    return 0.1 * random.uniform(0.05, 1) if any(effect.name == "holder_compliance" for effect in effects) else None


# ---- slip that is given ----


def slip(random: Random, kind: str, values: Mapping[str, Any], duration: float | None) -> Motion:
    """Slip velocity over time, and in part of the draws what else is given."""
    v_s = float(values.get("v_s", kernel.variable("v_s").start))
    speed = min(v_s * logarithmic(random, 0.3, 100), 1.0)
    stepped = bool(random.uniform() < 0.5)
    if kind in ("triangle", "sine"):
        times, velocity = _wave(random, kind, speed)
    else:
        corners, lengths = _corners(random, kind, speed)
        times, velocity = _cut(random, np.concatenate([[0.0], np.cumsum(lengths)]), corners, 1 if kind == "held" else None)
    if values["friction_law"] == "reset_integrator" and stepped:
        # at rest it sticks or slides, by the way in which the slip last turned: a host's rounding of 0 must not decide
        velocity = np.where(velocity == 0, 1e-6 * speed * np.sign(velocity[np.maximum(np.arange(len(velocity)) - 1, 0)] + 1e-300), velocity)
    if values["friction_law"] == "bristle":  # each bond breaks, and each break is an event
        reach = 3 * float(values.get("F_C", kernel.variable("F_C").start)) / float(values.get("sigma0", kernel.variable("sigma0").start))
        duration = min(duration or math.inf, 30 * reach / float(np.mean(np.abs(velocity)) + 1e-9), float(times[-1]))
    if duration is not None:
        times = times * (duration / times[-1])
    columns = {"slip_velocity": velocity, **_others(random, times, values)}
    return Motion.held(times, columns) if kind == "held" else Motion.record(times, columns, stepped=stepped)


def _cut(random: Random, times: FloatArray, corners: FloatArray, parts: int | None) -> tuple[FloatArray, FloatArray]:
    """Further communication points on the way from corner to corner."""
    parts = parts or int(random.choice([1, 1, 2, 5, 20]))
    fine = np.concatenate([np.linspace(a, b, parts, endpoint=False) for a, b in itertools.pairwise(times)] + [times[-1:]])
    between = np.interp(fine, times, corners)
    between[::parts] = corners
    return fine, between


def _corners(random: Random, kind: str, speed: float) -> tuple[FloatArray, FloatArray]:
    sign = float(random.choice([-1, 1]))
    if kind == "ramp":
        count = int(random.integers(2, 6))
        corners = speed * sign * random.uniform(0, 1, count + 1) ** 2
    elif kind == "stop":
        corners = sign * speed * np.array([*random.uniform(0.1, 1, int(random.integers(1, 3))), 0, 0])
    elif kind == "stop_and_go":
        corners = sign * speed * np.concatenate([[u, 0, 0, 0.5 * u * random.choice([-1, 1])] for u in random.uniform(0.1, 1, 3)])
    elif kind == "reversal":
        signs = sign * (-1.0) ** np.arange(int(random.integers(2, 7)))
        corners = speed * signs * random.uniform(0.05, 1, len(signs))
    elif kind == "plateau":
        corners = np.repeat(speed * random.uniform(-1, 1, int(random.integers(2, 4))), 2)
    else:
        corners = speed * random.uniform(-1, 1, int(random.integers(3, 8))) * random.choice([0, 1], p=[0.2, 0.8])
    return corners, np.array([logarithmic(random, 1e-3, 0.3) for _ in range(len(corners) - 1)])


def _wave(random: Random, kind: str, speed: float) -> tuple[FloatArray, FloatArray]:
    frequency, periods, samples = logarithmic(random, 1, 300), random.uniform(1, 4), int(random.integers(20, 500))
    times = np.linspace(0, periods / frequency, samples)
    turns = frequency * times + random.uniform()
    wave = np.sin(2 * math.pi * turns) if kind == "sine" else 4 * np.abs(turns % 1 - 0.5) - 1
    return times, speed * wave + 0.3 * speed * random.choice([0, 1]) * random.uniform(-1, 1)


def _others(random: Random, times: FloatArray, values: Mapping[str, Any]) -> dict[str, FloatArray]:
    """The inputs beside the slip, straight between a few corners that lie on samples."""
    friction_level = float(values.get("F_S", kernel.variable("F_S").start))

    def path(low: float, high: float) -> FloatArray:
        places = np.unique(np.concatenate([[0, len(times) - 1], random.integers(0, len(times), 4)]))
        return np.interp(times, times[places], random.uniform(low, high, len(places)))

    inputs: dict[str, FloatArray] = {}
    if random.uniform() < 0.4:
        thickness = path(2e-5, 2e-4)
        inputs["uncut_thickness"] = np.maximum(thickness - 8e-5, 0) if random.uniform() < 0.25 else thickness
    if random.uniform() < 0.4:
        inputs["normal_load"] = path(0, 30)
    if values["friction_law"] == "karnopp":
        inputs["applied_force"] = path(-1.5 * friction_level, 1.5 * friction_level)
    source = values.get("proxy_source", "slip_speed")
    if source == "contact_temperature":
        inputs["contact_temperature"] = path(280, 600)
    elif source != "slip_speed":
        inputs[source] = path(0, 0.5)
    return inputs


# ---- a tool that vibrates ----


def ellipse(random: Random) -> dict[str, Any]:
    """Frequency, amplitudes, phases, feed and speed ratio of the vibration."""
    frequency, a, b = logarithmic(random, 100, 4e4), logarithmic(random, 1e-6, 2e-5), logarithmic(random, 1e-6, 2e-5)
    values: dict[str, Any] = {
        "vibration_frequency": frequency,
        "amplitude_x": a,
        "amplitude_y": b,
        "feed": b * logarithmic(random, 0.3, 30),
        "chip_flow_shear_angle": random.uniform(0.25, 0.9),
        "cutting_speed": random.uniform(0.05, 1.5) * a * 2 * math.pi * frequency,
    }
    if random.uniform() < 0.5:
        values["phase_x"] = kernel.variable("phase_x").start + random.normal(0, 0.15)
        values["phase_y"] = kernel.variable("phase_y").start + random.normal(0, 0.15)
    if random.uniform() < 0.15:
        values["initial_state"] = "periodic"
    if random.uniform() < 0.2:
        values["averaging_window"] = random.uniform(0.3, 2.5) / frequency
    return values


def vibration(random: Random, kind: str, values: dict[str, Any]) -> Motion:
    """Some cycles; communication points that fall on no end of a window."""
    frequency, speed = values["vibration_frequency"], values.pop("cutting_speed")
    cycles, points = random.uniform(2, 6), random.uniform(3, 60)
    times = np.arange(0, cycles, 1 / points) / frequency
    columns = {"cutting_speed": np.full(times.shape, speed)}
    if random.uniform() < 0.3:
        columns["cutting_speed"] = speed * np.interp(times, [0, times[-1]], random.uniform(0.3, 1.3, 2))
    if kind == "combined":
        turns = times * frequency * random.uniform(0.03, 0.3) + random.uniform()
        size, w = values["amplitude_y"] * random.uniform(0, 0.5), 2 * math.pi * frequency * 0.1
        columns["tool_displacement_y"] = size * np.sin(2 * math.pi * turns)
        columns["tool_velocity_y"] = size * w * np.cos(2 * math.pi * turns)
        columns["tool_velocity_x"] = size * w * random.uniform(-1, 1) * np.sin(2 * math.pi * turns)
    if (source := values.get("proxy_source", "slip_speed")) in ("proxy_speed", "contact_temperature"):
        low, high = (280, 600) if source == "contact_temperature" else (0, 0.5)
        columns[source] = np.interp(times, [0, times[-1]], random.uniform(low, high, 2))
    if values["friction_law"] == "karnopp":
        columns["applied_force"] = np.full(times.shape, random.uniform(-10, 10))
    return Motion.record(times, columns, stepped=bool(random.uniform() < 0.5))
