"""What would the contact do if its laws were written a second time, slowly, straight from the equations?

An independent check on the C kernel, and the place to change a law with no compiler: plain Python, standard library only, one small
class per friction law (class ReferenceLaw says what a law answers). It shares variable names with the kernel, and no method: angles by
atan2, Radau collocation in time, Chandrupatla's method for roots. It has the laws of LAWS and the effects of EFFECTS; others are refused.

One file, because the Python FMU carries it as it stands: laws, effects, path, forces, the contact that runs them, arithmetic.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Any

Value = float | int | bool | str


class ContactError(ValueError):
    """What was asked cannot be done; the text says why. (Not an EvatError: inside an FMU nothing of the package can be imported.)"""


# ---- friction laws -------------------------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class Slide:
    """What a friction law sees of one moment, in SI. `direction` and `side` are held over a step, so that within it all is smooth."""

    p: Mapping[str, Any]  # every input and parameter
    v: float  # slip velocity [m/s]
    direction: float  # +1 or -1: which way it slips
    side: float  # +1 or -1: on which side of its own jump the law is
    theta: float  # temperature proxy [m/s]
    applied: float  # external tangential force [N]
    margin: float  # c of the dissipative limit; infinite: no limit
    s0: float  # stiffness [N/m] and damping [N s/m] in the force equation
    s1: float
    P: float = 0.0  # stiffness in the rate equation [N/m]
    kinks: list[float] = field(default_factory=list)  # numbers at whose change of sign something has a kink: steps are cut there
    clamped: bool = False  # whether a value was kept from leaving its range

    @property
    def speed(self) -> float:
        """|v| [m/s]."""
        return self.direction * self.v

    def at_most(self, value: float, bound: float) -> float:
        self.kinks.append(bound - value)
        return min(value, bound)

    def clamp(self, value: float, least: float) -> float:
        self.kinks.append(value - least)
        self.clamped |= value < least
        return max(value, least)


class ReferenceLaw:
    """A friction law: how fast its bristle bends, which force that makes, and where it jumps."""

    def rate(self, x: Slide, z: float) -> float:
        """dz/dt [m/s]."""
        return 0.0

    def force(self, x: Slide, z: float, dz: float) -> float:
        """Friction force on the tool along the chip flow [N]."""
        raise NotImplementedError

    def switch(self, x: Slide, z: float) -> float:
        """A number at whose change of sign the law jumps; x.side is the sign that it had last."""
        return 1.0

    def event(self, x: Slide, z: float) -> float:
        """The deflection behind a jump or a reversal of the slip."""
        return z


class Coulomb(ReferenceLaw):
    """F = F_C sgn(v)."""

    def force(self, x: Slide, z: float, dz: float) -> float:
        return x.direction * float(x.p["F_C"]) if x.v != 0 else 0.0


class LuGre(ReferenceLaw):
    """Canudas de Wit et al. 1995, with s0(theta) and s1(theta) of the paper's eq. 8."""

    @staticmethod
    def g(x: Slide) -> float:
        return float(x.p["F_C"] + (x.p["F_S"] - x.p["F_C"]) * math.exp(-((x.speed / x.p["v_s"]) ** x.p["lugre.stribeck_exponent"])))

    def rate(self, x: Slide, z: float) -> float:
        share = abs(x.P * z / self.g(x)) ** (float(x.p["lugre.presliding_exponent"]) - 1) if z != 0 else 1.0
        return x.v - x.P * x.speed * z / self.g(x) * share

    def force(self, x: Slide, z: float, dz: float) -> float:
        n = float(x.p["lugre.presliding_exponent"])
        least = (n + 1) ** ((n + 1) / n) / n  # 4 where n = 1: dissipative means |v| s1 <= 4 c g (s0/P)
        limit = least * x.margin * self.g(x) / x.speed * (x.s0 / x.P) if x.speed > 0 else math.inf
        power = x.p["lugre.viscous_exponent"] - 1
        viscous = x.p["sigma2"] * x.v * (x.speed / x.p["lugre.viscous_reference"]) ** power if x.speed > 0 else 0.0
        return float(x.s0 * z + x.at_most(x.s1, limit) * dz + viscous)


class Dahl(ReferenceLaw):
    """Dahl 1968: a bristle that saturates at F_C."""

    def rate(self, x: Slide, z: float) -> float:
        return float(x.v - x.P * x.speed * z / x.p["F_C"])

    def force(self, x: Slide, z: float, dz: float) -> float:
        return x.s0 * z


class Karnopp(ReferenceLaw):
    """Karnopp 1985: within a band of zero velocity the contact balances the applied force, up to F_S."""

    def switch(self, x: Slide, z: float) -> float:
        return float(x.p["karnopp.zero_velocity_band"]) - x.speed

    def force(self, x: Slide, z: float, dz: float) -> float:
        F_S = float(x.p["F_S"])
        return min(max(x.applied, -F_S), F_S) if x.side > 0 else x.direction * float(x.p["F_C"])


class ResetIntegrator(ReferenceLaw):
    """Haessig and Friedland 1991: follows the slip up to z0 = F_C/P, stiffer by F_S/F_C; then slides at F_C until the slip turns."""

    @staticmethod
    def z0(x: Slide) -> float:
        return float(x.p["F_C"]) / x.P

    def switch(self, x: Slide, z: float) -> float:
        outward = x.direction * z
        return -self.z0(x) if x.side < 0 and outward > 0 else self.z0(x) - max(outward, 0.0)

    def rate(self, x: Slide, z: float) -> float:
        return x.v if x.side > 0 else 0.0

    def force(self, x: Slide, z: float, dz: float) -> float:
        return float(x.s0 * (z * x.p["F_S"] / x.p["F_C"] if x.side > 0 else x.direction * self.z0(x)) + x.s1 * dz)

    def event(self, x: Slide, z: float) -> float:
        return min(max(z, -self.z0(x)), self.z0(x))


LAWS: dict[str, ReferenceLaw] = {
    "coulomb": Coulomb(),
    "lugre": LuGre(),
    "dahl": Dahl(),
    "karnopp": Karnopp(),
    "reset_integrator": ResetIntegrator(),
}


# ---- effects of the temperature proxy, each with its switch's name --------------------------------------------------------------------


def soften(x: Slide) -> None:
    """The paper, eq. 6."""
    x.s0 -= x.p["thermal_softening.k_Q"] * (x.theta / x.p["theta_ref"]) ** x.p["thermal_softening.Q"]


def damp(x: Slide) -> None:
    """The paper, eq. 5."""
    x.s1 *= (x.theta / x.p["theta_ref"]) ** x.p["thermal_damping.alpha2"]


EFFECTS: dict[str, Callable[[Slide], None]] = {"thermal_softening": soften, "thermal_damping": damp}


# ---- path of the tool and thickness of the chip ---------------------------------------------------------------------------------------


@dataclass(slots=True)
class Moment:
    """Motion and engagement at one time."""

    tau: float  # seconds after the last communication point
    v: float  # slip velocity at the constant shear angle [m/s]
    h: float  # uncut thickness [m]
    u_x: float = 0.0  # velocity of the tool relative to the work [m/s]
    u_y: float = 0.0
    approach: float = 1.0  # its part into the chip [m/s]
    surface: Stroke | None = None  # that has left what bounds the chip above; None: the nominal surface
    reach: float = 1.0  # how far the stroke before goes on [amplitudes]; below 0: it does not come so far (see Loops.indicator)
    speed_ratio: float = 0.0

    @property
    def in_contact(self) -> bool:
        return self.h > 0 and self.approach > 0


Stroke = tuple[int, int]  # how many cycles ago; 1: on the way forward, -1: on the way back


@dataclass(slots=True)
class Loops:
    """The path as the cut that lasts at `psi` sees it: x/a = r psi + sin(psi), y = b cos(psi + lead). The tool moves forward from -q to q
    in each cycle, cos(q) = -r, and back from q - 2 pi to -q. psi is counted from the cycle in which the tool moves into the material
    fastest nearest to it, and `begun` is where it last began to do so: what it has done since is the present cut and leaves nothing yet."""

    r: float
    lead: float
    psi: float
    begun: float = 0.0
    q: float = 0.0
    alone: bool = False  # what is cut can have been left by the forward stroke before alone

    def __post_init__(self) -> None:
        self.q = math.acos(-self.r)

    def count_from(self, alpha: float, aspect: float) -> Loops:
        """With approach / (a w) = r cos(alpha) + A cos(psi - fastest)."""
        tilted = aspect * math.sin(alpha)
        C, S = math.cos(alpha) - tilted * math.sin(self.lead), -tilted * math.cos(self.lead) if alpha else 0.0
        fastest = math.atan2(S, C)
        size = math.hypot(C, S)
        half = math.acos(-min(self.r * math.cos(alpha) / size, 1.0) if size > 0 else -1.0)
        self.begun = fastest - half
        self.alone = half < math.pi and self._one_valley() and self._gets_on(fastest + half)
        middle = 0.0 if self.alone else fastest
        self.psi -= 2 * math.pi * math.floor((self.psi - middle) / (2 * math.pi) + 0.5)
        if self.psi < self.begun:  # a machine moves the tool into the material before its vibration does
            self.begun = max(turn for turn in (-self.q - 2 * math.pi, self.q - 2 * math.pi, -self.q, self.q) if turn <= self.psi)
        return self

    def _one_valley(self) -> bool:
        """Is the forward stroke one valley, and its left end above what the cycle before left there?"""
        tilt = math.remainder(self.lead - math.pi, 2 * math.pi)
        there = Loops(self.r, self.lead, -self.q)
        return abs(tilt) <= math.pi - self.q and math.cos(self.lead - self.q) >= math.cos(there.passed((1, 1))[0] + self.lead)

    def _gets_on(self, stops: float) -> bool:
        """Does the cut that begins at `begun` lie within a turn and stop no further back than on the forward stroke it began?"""
        place, stop = (self.r * psi + math.sin(psi) for psi in (self.begun, stops))
        return self.begun >= -math.pi and stops <= math.pi and (self.begun <= -self.q or stop >= place)

    def indicator(self) -> float:
        """Distance to the end of the stroke before; where all strokes count, to the nearest end of any of 16, changing sign at each."""
        reach, pitch = self.ahead(self.q - 2 * math.pi), 2 * math.pi * self.r
        nearest = 0 if self.alone else min(max(math.floor(reach / pitch + 0.5), 0), 15)
        return (reach - nearest * pitch) * (1 if nearest % 2 == 0 else -1)

    def ends(self, stroke: Stroke) -> tuple[float, float]:
        """Angles of its left and its right end."""
        cycles, way = stroke
        left, right = (-self.q, self.q) if way > 0 else (-self.q, self.q - 2 * math.pi)
        return left - 2 * math.pi * cycles, right - 2 * math.pi * cycles

    def ahead(self, other: float) -> float:
        return self.r * (other - self.psi) + math.sin(other) - math.sin(self.psi)

    def passed(self, stroke: Stroke) -> tuple[float, float]:
        """When it passed the present place, and how far beyond this place it came (below 0: not so far, and the angle is that of its
        end)."""
        left, right = self.ends(stroke)
        reach = self.ahead(right)
        return (root(self.ahead, left, right, 1e-15)[1] if reach >= 0 else right), reach

    def candidates(self) -> Iterator[Stroke]:
        """Strokes of which one has left the lowest height. Of one kind each passed the place where the one after it would have passed a
        pitch further on: none but the newest, the oldest and those beside the lowest point of the stroke can be the lowest."""
        pitch, place = 2 * math.pi * self.r, self.r * self.psi + math.sin(self.psi)
        oldest = math.floor((self.r * self.q + math.sin(self.q) - place) / pitch)
        for way in (1, -1):
            newest, last = (0, oldest) if way > 0 else (-1, oldest - 1)
            lowest = math.pi - self.lead - 2 * math.pi * math.floor((math.pi - self.lead) / (2 * math.pi) + (0.5 if way > 0 else 1))
            beside = math.floor((self.r * lowest + math.sin(lowest) - place) / pitch)
            for cycles in sorted({newest, newest + 1, newest + 2, beside, beside + 1, last}):
                left, right = self.ends((cycles, way))
                if newest <= cycles <= last and min(left, right) < self.begun and self.ahead(left) <= 0:
                    yield cycles, way

    def lowest(self) -> tuple[float, Stroke | None]:
        """Height in b that all older strokes have left here, and which of them; infinity where none came so far."""
        if self.alone:
            then, reach = self.passed((1, 1))
            return (math.cos(then + self.lead), (1, 1)) if reach >= 0 else (math.inf, None)
        best: tuple[float, Stroke | None] = (math.inf, None)
        for stroke in self.candidates():
            then, _ = self.passed(stroke)
            if then <= self.begun and (height := math.cos(then + self.lead)) < best[0]:
                best = height, stroke
        return best


def cusps(r: float, lead: float) -> float:
    """Height in b of the surface that all strokes leave, above the bottom of the path: at its highest over one advance."""
    if r <= 1e-12 or r >= 1:
        return 0.0 if r < 1 else 2.0
    q = math.acos(-r)
    if abs(lead - math.pi) < 1e-9:  # upright: one forward stroke meets the next
        return 1 - math.cos(root(lambda entry: r * (math.pi - entry) - math.sin(entry), 0.0, q, 1e-15)[1])

    def left(psi: float) -> float:
        """Where the forward stroke passes at psi, when it has ended."""
        return Loops(r, lead, psi, begun=q).lowest()[0]

    start = r * -q - math.sin(q)
    end = root(lambda psi: r * psi + math.sin(psi) - start - 2 * math.pi * r, -q, q, 1e-15)[1]
    marks = [-q + (end + q) * n / 96 for n in range(97)]
    heights = [left(psi) for psi in marks]
    best = max(heights)
    for n, height in enumerate(heights):
        low, high = marks[max(n - 1, 0)], marks[min(n + 1, 96)]
        if height < max(heights[max(n - 1, 0)], heights[min(n + 1, 96)]):
            continue
        for _ in range(90):  # thirds: the surface rises and then falls between the two
            one, other = low + (high - low) / 3, high - (high - low) / 3
            there = left(one), left(other)
            best = max(best, *there)
            low, high = (low, other) if there[0] > there[1] else (one, high)
    return 1 + best


# ---- from friction to cutting forces --------------------------------------------------------------------------------------------------

FLATTEST, STEEPEST = 0.02, 1.5  # where the chip flows along the current shear angle: least phi, largest phi - alpha [rad]


def normal_force(*, F: float, k: float, alpha: float, principle: str) -> float:
    """N on the rake from friction F and shear load k, below 0 where the chip would have to pull.

    R = k/(sin(phi) cos(phi + beta - alpha)), N = R cos(beta); the angles are cleared of the division F/k.
    """
    if principle == "maximum_shear_stress":  # tan(beta) = f sin(s)/(sqrt(2) + f cos(s))
        s = math.pi / 4 + alpha
        beta = math.atan2(F * math.sin(s), math.sqrt(2) * k + F * math.cos(s))
    else:  # beta = asin(f/hypot(A, B)) + atan2(B, A); the arcsine keeps its digits near pi/2 as atan2(f, sqrt(hypot^2 - f^2))
        A, B, D = 2 * k + F * math.cos(alpha), F * math.sin(alpha), k * (k + F * math.cos(alpha))
        if D < 0:  # no such angle: the edge of the domain is carried on
            return -A * math.sin(alpha) / math.cos(alpha) ** 2
        beta = math.atan2(F, 2 * math.sqrt(D)) + math.atan2(B, A)
    if abs(F) > 1e-3 * k:
        return F / math.tan(beta)
    phi = shear_angle(beta=beta, alpha=alpha, principle=principle)
    return k / (math.sin(phi) * math.cos(phi + beta - alpha)) * math.cos(beta)


def shear_angle(*, beta: float, alpha: float, principle: str) -> float:
    return math.pi / 4 - (beta - alpha) * (1 if principle == "maximum_shear_stress" else 0.5)


# ---- the contact ----------------------------------------------------------------------------------------------------------------------


@dataclass(slots=True)
class Point:
    """What the contact answers at one moment."""

    x: Slide
    dz: float
    F: float = 0.0
    N: float = 0.0
    phi: float = 0.0
    F_p: float = 0.0
    F_f: float = 0.0
    P_s: float = 0.0  # shear force times shear velocity [W]


Nodes = list[tuple[float, Point]]  # deflection and answer at the nodes of a step
INTEGRALS: dict[str, Callable[[Point], float]] = {
    "friction_impulse": lambda now: now.F,
    "principal_impulse": lambda now: now.F_p,
    "feed_impulse": lambda now: now.F_f,
    "normal_impulse": lambda now: now.N,
    "contact_time": lambda now: 1.0,
    "measured_friction_impulse": lambda now: now.F,
    "measured_principal_impulse": lambda now: now.F_p,
    "measured_feed_impulse": lambda now: now.F_f,
    "sliding_distance": lambda now: abs(now.x.v),
    "dissipated_energy": lambda now: now.F * now.x.v,
    "shear_energy": lambda now: now.P_s,
}
MEANS = {  # over the last averaging window, and the integral that each is formed from
    "mean_friction_force": "friction_impulse",
    "mean_principal_force": "principal_impulse",
    "mean_feed_force": "feed_impulse",
    "mean_normal_force": "normal_impulse",
    "mean_contact_ratio": "contact_time",
    "mean_measured_friction_force": "measured_friction_impulse",
    "mean_measured_principal_force": "measured_principal_impulse",
    "mean_measured_feed_force": "measured_feed_impulse",
    "mean_dissipated_power": "dissipated_energy",
    "mean_shear_power": "shear_energy",
}


def copied(values: Mapping[str, Any]) -> dict[str, Any]:
    return {name: dict(value) if isinstance(value, dict) else value for name, value in values.items()}


class ReferenceContact:
    """One contact. `values` names every input, parameter and state (SI; a choice by its word, a switch as bool)."""

    def __init__(self, values: Mapping[str, Value]) -> None:
        self.p: dict[str, Any] = dict(values)
        self.slope: dict[str, float] = {}  # rate of an input within the next advance [1/s]; absent: held
        self.out: dict[str, float] = {}
        self.time = self.window_origin = 0.0
        self.z, self.direction, self.side = 0.0, 1.0, 1.0
        self.integral, self.means = dict.fromkeys(INTEGRALS, 0.0), dict.fromkeys(MEANS, 0.0)
        self.window_start, self.windows, self.steps, self.clamped = dict(self.integral), 0, 0, 0
        self.begun = dict(self.integral)  # what `recent_` integrals are counted from: nobody acts on its events from outside
        self.h = math.inf  # internal step that the last one suggests [s]
        self.cusps = {"r": 0.0, "lead": 0.0, "height": 0.0}  # of the ellipse looked at last

    def set(self, name: str, value: Value) -> None:
        """Change an input, a parameter, or before `start` the first value of a state."""
        if name not in self.p:
            raise ContactError(f"{name!r} is no input, parameter or state of this contact; it has {', '.join(sorted(self.p))}.")
        if not isinstance(value, str) and not math.isfinite(value):
            raise ContactError(f"{name} = {value}: a finite number is needed.")
        self.p[name] = value

    def get(self, name: str) -> Value:
        """An output at the last evaluated moment, an input or a parameter."""
        value: Value | None = self.out.get(name, self.p.get(name))
        if value is None:
            raise ContactError(f"there is no variable {name!r} in this contact.")
        return value

    def state(self) -> dict[str, Any]:
        """Everything there is, as plain numbers and words; `restore` takes it back exactly."""
        return copied(vars(self))

    def restore(self, state: Mapping[str, Any]) -> None:
        if state.keys() != vars(self).keys():
            raise ContactError(f"this is no state of a contact: it holds {sorted(state)}, needed are {sorted(vars(self))}.")
        vars(self).update(copied(state))

    def start(self, time: float) -> None:
        """Begin at `time` [s]: bristles as set, or in the steady state of the vibration cycle."""
        p = self.p
        if p["friction_law"] not in LAWS:
            raise ContactError(f"friction_law = {p['friction_law']}: not written here, allowed are {', '.join(LAWS)}; use the native FMU.")
        foreign = [name for name, value in p.items() if value is True and name not in EFFECTS]
        if foreign:
            raise ContactError(f"{', '.join(foreign)}: not written here, allowed are {', '.join(EFFECTS)}; use the native FMU.")
        if p["averaging"] != "resolved":
            raise ContactError(f"averaging = {p['averaging']}: not written here, allowed is resolved; use the native FMU.")
        if p["friction_law"] == "karnopp" and self._current_angle:
            raise ContactError("friction_law = karnopp has no single slip with chip_flow_angle = current_shear_angle; change one of them.")
        if p["proxy_source"] == "contact_temperature" and p["reference_temperature"] <= p["ambient_temperature"]:
            raise ContactError("reference_temperature must lie above ambient_temperature; raise it.")
        self.time, self.window_origin, self.z = time, time, p["bristle_deflection"]
        self.integral = {name: p[name if name == "sliding_distance" else f"recent_{name}"] for name in INTEGRALS}
        self.window_start, self.begun = dict(self.integral), dict(self.integral)
        if p["initial_state"] == "periodic" and p["kinematics"] != "external":
            self.z = self._periodic()
        self.evaluate()

    def _periodic(self) -> float:
        """The deflection that returns after one period: secant steps, one of which is enough where the law is linear in it."""
        kept, grain = self.state(), self.p["F_C"] / self.p["sigma0"]

        def gain(z: float) -> float:
            self.restore({**kept, "z": z})
            self._go_on(1 / self.p["vibration_frequency"])
            return self.z - z

        z0, f0 = 0.0, gain(0.0)
        z1, f1 = f0, gain(f0)
        for _ in range(50):
            if abs(f1) <= 1e-14 * grain or f1 == f0:
                break
            z0, f0, z1 = z1, f1, z1 - f1 * (z1 - z0) / (f1 - f0)
            f1 = gain(z1)
        self.restore(kept)
        return z1

    # -- one moment

    @property
    def law(self) -> ReferenceLaw:
        return LAWS[self.p["friction_law"]]

    @property
    def _current_angle(self) -> bool:
        return bool(self.p["chip_flow_angle"] == "current_shear_angle" and self.p["kinematics"] != "external")

    @property
    def _tolerance(self) -> float:
        """What a step may miss: less than what is asked for at the end of many, more than rounding."""
        return float(min(max(0.1 * self.p["relative_tolerance"], 1e-13), 1e-6))

    def _input(self, name: str, tau: float) -> float:
        return float(self.p[name]) + self.slope.get(name, 0.0) * tau

    def _moment(self, tau: float, surface: Stroke | str | None = "lowest") -> Moment:
        """Motion and thickness; under what a given stroke has left (None: the nominal surface), or under what stands there."""
        p = self.p
        if p["kinematics"] == "external":
            return Moment(tau, v=self._input("slip_velocity", tau), h=self._input("uncut_thickness", tau))
        f, a, b, alpha = p["vibration_frequency"], p["amplitude_x"], p["amplitude_y"], p["rake_angle"]
        v_c, w, turn = self._input("cutting_speed", tau), 2 * math.pi * f, 2 * math.pi * (math.fmod(f * self.time, 1.0) + f * tau)
        u_x, u_y, y = v_c - a * w * math.sin(turn + p["phase_x"]), -b * w * math.sin(turn + p["phase_y"]), b * math.cos(turn + p["phase_y"])
        stands: Stroke | None
        h, stands, reach, r = p["feed"] - b - y, None, -1.0, v_c / (a * w) if a > 0 else math.inf
        if p["kinematics"] == "combined":  # the previous cycle is taken to have had the same displacement
            u_x += self._input("tool_velocity_x", tau)
            u_y += self._input("tool_velocity_y", tau)
            h -= self._input("tool_displacement_y", tau)
        approach = u_x * math.cos(alpha) + u_y * math.sin(alpha)
        if r < 1 and approach > 0:
            phase = p["phase_x"] + math.pi / 2
            loops = Loops(r, p["phase_y"] - phase, turn + phase).count_from(alpha, b / a)
            older: Stroke | None = (1, 1)
            left, reach = 0.0, 0.0  # without feed motion the same path again
            if r > 1e-12:
                reach = loops.indicator()
                if isinstance(surface, tuple):
                    height, older = math.cos(loops.passed(surface)[0] + loops.lead), surface
                else:
                    height, older = loops.lowest() if surface else (math.inf, None)
                left = b * height - y if older else math.inf
            if isinstance(surface, tuple) or left < h:
                h, stands = left, older
        v = approach * math.tan(p["chip_flow_shear_angle"] - alpha) + u_x * math.sin(alpha) - u_y * math.cos(alpha)
        return Moment(tau, v, h, u_x, u_y, approach, stands, reach, r if a > 0 else 0.0)

    def _slide(self, tau: float, v: float, direction: float, side: float) -> Slide:
        """What the law sees at slip v, with the effects that are on."""
        p, warmer = self.p, 1.0
        if p["proxy_source"] == "slip_speed":
            theta = abs(v)
        elif p["proxy_source"] == "contact_temperature":  # the paper, eq. 3, turned round
            warmer = self._input("contact_temperature", tau) - p["ambient_temperature"]
            share = max(warmer, 0.0) / (p["reference_temperature"] - p["ambient_temperature"])
            theta = p["theta_ref"] * share ** (1 / p["alpha_T"])
        else:
            theta = max(self._input(p["proxy_source"], tau), 0.0)
        margin = p["damping_margin"] if p["damping_mode"] == "dissipative" else math.inf
        x = Slide(p, v, direction, side, theta, self._input("applied_force", tau), margin, s0=p["sigma0"], s1=p["sigma1"])
        x.clamp(warmer, 0.0)
        for name, act in EFFECTS.items():
            if p[name]:
                act(x)
        x.s0 = x.clamp(x.s0, p["stiffness_floor"] * p["sigma0"])  # the paper, eq. 7
        x.P = x.s0 if p["rate_stiffness"] == "thermal" else p["sigma0"]
        return x

    def _forces(self, m: Moment, x: Slide, dz: float, F: float) -> Point:
        p = self.p
        alpha, principle, k = p["rake_angle"], p["shear_angle_principle"], p["shear_stress"] * p["width"] * max(m.h, 0.0)
        if principle == "minimum_energy":
            x.clamp(k + F * math.cos(alpha), 0.0)  # the domain of its closed form
        N = x.clamp(normal_force(F=F, k=k, alpha=alpha, principle=principle) if F != 0 or k > 0 else 0.0, 0.0)
        phi = shear_angle(beta=math.atan2(F, N) if F != 0 else 0.0, alpha=alpha, principle=principle)
        c, s = math.cos(alpha), math.sin(alpha)
        plane = phi if self._current_angle else p["chip_flow_shear_angle"]  # on which the chip is sheared
        turned = plane - alpha
        steady = max(x.v, 0.0) * c / math.sin(plane)  # shear velocity where only the slip is given
        V_s = steady if p["kinematics"] == "external" else m.approach / math.cos(turned)
        P_s = (N * math.cos(turned) - F * math.sin(turned)) * V_s
        return Point(x, dz, F, N, phi, F_p=N * c + F * s, F_f=F * c - N * s, P_s=P_s)

    def _answer(self, m: Moment, v: float, z: float, direction: float, side: float) -> Point:
        """In contact at slip v."""
        x = self._slide(m.tau, v, direction, side)
        dz = self.law.rate(x, z)
        return self._forces(m, x, dz, self.law.force(x, z, dz))

    def _flow(self, m: Moment, phi: float) -> float:
        """Slip of a chip that flows along the shear angle phi."""
        alpha = self.p["rake_angle"]
        tangent = math.tan(min(max(phi, FLATTEST) - alpha, STEEPEST))
        return float(m.approach * tangent + m.u_x * math.sin(alpha) - m.u_y * math.cos(alpha))

    def _cutting(self, m: Moment, z: float, direction: float, side: float) -> Point:
        """In contact, on the side of the law's jump and in the direction of slip (0: the chip sticks) that are held."""
        if not self._current_angle:
            return self._answer(m, m.v, z, direction, side)
        if direction == 0:  # v = 0, and the friction is what keeps it so
            x = self._slide(m.tau, 0.0, self.direction, side)
            back, forth = (self._answer(m, way * 1e-300, z, way, self._along(m, z, way)[1]).F for way in (-1.0, 1.0))  # ends of the jump
            close = 1e-16 * (abs(back) + abs(forth))
            return self._forces(m, x, 0.0, root(lambda F: -self._flow(m, self._forces(m, x, 0.0, F).phi), back, forth, close)[1])
        low, high = self._flow(m, FLATTEST), self._flow(m, math.inf)
        close = 1e-16 * max(abs(low), abs(high))
        v = root(lambda v: v - self._flow(m, self._answer(m, v, z, direction, side).phi), low, high, close)[1]
        point = self._answer(m, v, z, direction, side)
        point.x.kinks += [point.phi - FLATTEST, STEEPEST + self.p["rake_angle"] - point.phi]
        return point

    def _along(self, m: Moment, z: float, direction: float) -> tuple[float, float]:
        """How fast the chip slips in a direction (below 0: it does not slip that way), and on which side of its jump the law then is."""
        x = self._slide(m.tau, 0.0 if self._current_angle else m.v, direction, self.side)
        side = 1.0 if self.law.switch(x, z) > 0 else -1.0
        return direction * (self._cutting(m, z, direction, side).x.v if self._current_angle else m.v), side

    def _sides(self, m: Moment, z: float) -> tuple[float, float]:
        """Which way the chip slips (0: neither way, it sticks), and the side of the law's jump."""
        for direction in (self.direction, -self.direction):
            speed, side = self._along(m, z, direction)
            if speed >= 0:
                self.direction, self.side = direction, side
                return direction, side
        return 0.0, self.side

    def _watched(self, m: Moment, z: float, point: Point, direction: float, side: float) -> list[float]:
        """Numbers at whose change of sign a step is cut; the first two are above 0 as long as direction and side hold."""
        if direction == 0:
            return [-self._along(m, z, way)[0] for way in (1.0, -1.0)]
        return [direction * point.x.v, side * self.law.switch(point.x, z), *point.x.kinks]

    def _indicators(self, m: Moment, x: Slide) -> dict[str, float]:
        """The event indicators, of order 1, each with a hysteresis towards the side that is held."""
        late, p = 1e-9, self.p
        thickness = m.h / 1e-6 if p["kinematics"] == "external" else min(m.h / 1e-6, m.approach)
        shown = dict.fromkeys(("surface_indicator", "slip_indicator", "law_indicator"), 1.0)
        if m.in_contact:
            law = 1.0 if self._current_angle else self.law.switch(x, self.z)
            if self._current_angle:
                pass
            elif isinstance(self.law, Karnopp):
                law /= 1e-3
            elif isinstance(self.law, ResetIntegrator):
                law /= self.law.z0(x)
            slip = 1.0 if self._current_angle else m.v / 1e-3
            sides = (math.copysign(1.0, m.reach), 1.0 if self._current_angle else self.direction, self.side)
            shown = {name: value + late * side for name, value, side in zip(shown, (m.reach, slip, law), sides, strict=True)}
        return {"contact_indicator": thickness + late * (1.0 if m.in_contact else -1.0), **shown}

    def _cusp_height(self, m: Moment) -> float:
        p = self.p
        if p["kinematics"] == "external":
            return 0.0
        r = m.speed_ratio if p["amplitude_x"] > 0 else math.inf if p["cutting_speed"] > 0 else 0.0
        lead = p["phase_y"] - p["phase_x"] - math.pi / 2
        if (self.cusps["r"], self.cusps["lead"]) != (r, lead):
            self.cusps = {"r": r, "lead": lead, "height": cusps(r, lead)}
        return min(float(p["amplitude_y"]) * self.cusps["height"], float(p["feed"]))

    def evaluate(self) -> None:
        """Outputs at the present time, from the state and the inputs as they stand."""
        m, p = self._moment(0.0), self.p
        if m.in_contact:
            point = self._cutting(m, self.z, *self._sides(m, self.z))
        else:
            phi = shear_angle(beta=0.0, alpha=p["rake_angle"], principle=p["shear_angle_principle"])
            v, release = self._flow(m, phi) if self._current_angle else m.v, p["release_time"]
            self.direction, self.side = math.copysign(1.0, v) if v != 0 else self.direction, 1.0
            self.z = self.z if release > 0 else 0.0
            point = Point(self._slide(0.0, v, self.direction, 1.0), dz=-self.z / release if release > 0 else 0.0, phi=phi)
        self.out = {
            "time": self.time,
            "friction_force": point.F,
            "principal_force": point.F_p,
            "feed_force": point.F_f,
            "normal_force": point.N,
            "measured_friction_force": point.F,
            "measured_principal_force": point.F_p,
            "measured_feed_force": point.F_f,
            "tool_force_x": -point.F_p,
            "tool_force_y": point.F_f,
            "slip_velocity_used": point.x.v,
            "uncut_thickness_used": m.h if m.in_contact else 0.0,
            "theta_used": point.x.theta,
            "shear_angle": point.phi,
            "speed_ratio": m.speed_ratio,
            "cusp_height": self._cusp_height(m),
            "in_contact": float(m.in_contact),
            "contact_rate": float(m.in_contact),
            "bristle_deflection": self.z,
            "bristle_rate": point.dz,
            "dissipated_power": point.F * point.x.v,
            "shear_power": point.P_s,
            "sliding_speed": abs(point.x.v) if m.in_contact else 0.0,
            "step_count": self.steps,
            "averaging_error": 0.0,
            "clamped_count": self.clamped,
            **self._indicators(m, point.x),
            **self.integral,
            **{f"recent_{of}": self.integral[of] - self.begun[of] for of in MEANS.values()},
        }
        if self._window() == 0:
            rates = {name: what(point) for name, what in INTEGRALS.items()}
            self.means = {name: rates[of] if m.in_contact else 0.0 for name, of in MEANS.items()}
        self.out |= self.means

    # -- through time

    def advance(self, step: float) -> None:
        """Go on by `step` [s] with the inputs as they stand, plus `slope` times the time gone; then evaluate."""
        if not (math.isfinite(step) and step > 0):
            raise ContactError(f"step = {step} s: a positive finite number is needed.")
        cycles = 1 if self.p["kinematics"] == "external" else math.ceil(step * self.p["vibration_frequency"])
        start = self.time
        for n in range(cycles):  # one at a time: angles stay small, and so does their rounding
            self._go_on(start + step * ((n + 1) / cycles) - self.time)
        self.time = start + step
        self.evaluate()

    def _go_on(self, step: float) -> None:
        closing = set(self._window_ends(step))
        edges = sorted({0.0, step, *closing, *self._edges(step)})
        for start, end in pairwise(edges):
            m, release = self._moment((start + end) / 2), self.p["release_time"]
            if m.in_contact:
                self._cut(start, end, m.surface)
            else:
                self.z *= math.exp((start - end) / release) if release > 0 else 0.0
                self.side = 1.0
            if end in closing:
                self.means = {name: (self.integral[of] - self.window_start[of]) / self._window() for name, of in MEANS.items()}
                self.window_start, self.windows = dict(self.integral), self.windows + 1
        for name, slope in self.slope.items():
            self.p[name] += slope * step
        self.time += step

    def _window(self) -> float:
        """Length of the averaging window [s]; 0: none."""
        p = self.p
        return float(p["averaging_window"]) or (0.0 if p["kinematics"] == "external" else 1 / p["vibration_frequency"])

    def _window_ends(self, step: float) -> Iterator[float]:
        length, n, end = self._window(), self.windows, 0.0
        while length > 0 and end < step:
            n += 1
            end = self.window_origin + n * length - self.time
            if end <= step + 1e-9 * length:  # ends that differ from the step's by rounding only are the step's
                yield end if end < step - 1e-9 * length else step

    def _edges(self, step: float) -> Iterator[float]:
        """Times in (0, step) at which contact, the surface that stands, or the way of the tool changes: to the last bit, by
        bisection. Out of contact too it counts where the tool turns and a surface ends: there the shortest contacts lie."""
        p = self.p

        def mode(tau: float) -> tuple[bool, bool, Stroke | None, bool]:
            m = self._moment(tau)
            return m.in_contact, m.approach > 0, m.surface, m.in_contact or m.reach >= 0

        samples = {0.0, step}
        if p["kinematics"] != "external":
            f, share = p["vibration_frequency"], math.fmod(p["vibration_frequency"] * self.time, 1.0)
            a, b, alpha = p["amplitude_x"], p["amplitude_y"], p["rake_angle"]
            into = [a * math.cos(alpha) * c(p["phase_x"]) + b * math.sin(alpha) * c(p["phase_y"]) for c in (math.sin, math.cos)]
            for angle in (p["phase_y"], math.atan2(*into)):  # the lowest point and the fastest approach are among the samples
                first = share + angle / (2 * math.pi)
                samples |= {(n / 32 - first) / f for n in range(math.ceil(32 * first), math.ceil(32 * (first + f * step)))}
        times = sorted(tau for tau in samples if 0 <= tau <= step)
        for before, after in pairwise(times):
            low = before
            while (old := mode(low)) != mode(after):
                high = after
                while high - low > 4e-16 * step and low < (middle := (low + high) / 2) < high:
                    low, high = (middle, high) if mode(middle) == old else (low, middle)
                yield high
                low = high

    def _cut(self, start: float, end: float, surface: Stroke | None) -> None:
        """Through a piece of contact under one surface, in steps that are cut where anything jumps or kinks."""
        resolution, tau, idle, h = 4e-16 * (abs(end) + end - start), start, 0, min(self.h, end - start)
        while end - tau > resolution:
            m = self._moment(tau, surface)
            direction, side = self._sides(m, self.z)
            signs = [value < 0 for value in self._watched(m, self.z, self._cutting(m, self.z, direction, side), direction, side)]
            step = Step(self, tau, surface, direction, side, [False, False, *signs[2:]])
            h = min(h, end - tau) if end - tau > 1.01 * h else end - tau
            h, changed = step.up_to_event(h, resolution)
            least = 4 * resolution * 8**idle  # the same event again and again within rounding: a little further behind it
            h = min(max(h, least), end - tau) if idle and changed is not None else h
            nodes, bad = step.doubled(h, end - start)
            before = math.inf
            while (
                bad > 1 and h > 4 * resolution and not 0.5 * before < bad < 1e-11 / self._tolerance
            ):  # not mended by a shorter step: rounding
                h, changed, before = h * min(max(0.8 * bad ** (-1 / 8), 0.1), 0.7), None, bad
                nodes, bad = step.doubled(h, end - start)
            if not nodes:
                raise ContactError(f"no bristle deflection was found at {self.time + tau} s; loosen relative_tolerance.")
            for half in nodes:
                for name, what in INTEGRALS.items():
                    self.integral[name] += h / 2 * mean(half, what)
            (self.z, last), tau, self.steps = nodes[-1][-1], tau + h, self.steps + 1
            self.clamped += last.x.clamped
            if direction != 0 and changed in (0, 1):
                self.z = self.law.event(last.x, self.z)
                self.direction, self.side = (-direction, side) if changed == 0 else (direction, -side)
            idle = idle + 1 if changed is not None and h <= least else 0
            if idle > 12:
                raise ContactError(
                    f"the friction law keeps switching between its branches at {self.time + tau} s; change the law or chip_flow_angle."
                )
            grown = h * min(max(0.8 * max(bad, 1e-9) ** (-1 / 8), 0.2), 4.0)
            self.h = h = grown if changed is None or math.isinf(self.h) else max(grown, self.h)  # short for an event only


@dataclass(slots=True)
class Step:
    """Radau steps of one contact from one time, with direction and side held. signs: which watched numbers are below 0 there."""

    contact: ReferenceContact
    tau: float
    surface: Stroke | None
    direction: float
    side: float
    signs: list[bool]

    def nodes(self, tau: float, z: float, h: float) -> Nodes:
        """Deflection and answer at the nodes of one step; empty where none was found."""
        contact, held = self.contact, (self.direction, self.side)
        moments = [contact._moment(tau + c * h, self.surface) for c in NODES]

        def rate(n: int, z: float) -> float:
            m = moments[n]
            return contact._cutting(m, z, *held).dz if contact._current_angle else contact.law.rate(contact._slide(m.tau, m.v, *held), z)

        deflections = collocate(rate, z, h, contact.p["F_C"] / contact.p["sigma0"])
        return [(z_n, contact._cutting(m, z_n, *held)) for m, z_n in zip(moments, deflections, strict=True)] if deflections else []

    def held(self, tau: float, z: float, point: Point) -> list[float]:
        """The watched numbers, each turned so that it is below 0 once it has changed its sign."""
        m = self.contact._moment(tau, self.surface)
        values = self.contact._watched(m, z, point, self.direction, self.side)
        return [-value if below else value for value, below in zip(values, self.signs, strict=False)]

    def up_to_event(self, h: float, resolution: float) -> tuple[float, int | None]:
        """Length of the step that ends just behind the first event in it, and the place of the number that changed; or h and None."""

        def at_end(length: float) -> list[float]:
            nodes = self.nodes(self.tau, self.contact.z, length)
            return self.held(self.tau + length, *nodes[-1]) if nodes else [math.nan]

        for c, now in zip(NODES, self.nodes(self.tau, self.contact.z, h), strict=False):
            if min(self.held(self.tau + c * h, *now)) < 0 and min(at_end(c * h)) < 0:
                length = root(lambda length: min(at_end(length)), 0.0, c * h, resolution)[1]
                values = at_end(length)
                return length, values.index(min(values))
        return h, None

    def doubled(self, h: float, piece: float) -> tuple[list[Nodes], float]:
        """Two half steps, and how far one whole step is from them, in tolerances on deflection, forces and, over the piece, impulses."""
        whole, half = self.nodes(self.tau, self.contact.z, h), self.nodes(self.tau, self.contact.z, h / 2)
        rest = self.nodes(self.tau + h / 2, half[-1][0], h / 2) if half else []
        if not whole or not rest:
            return [], math.inf
        (z1, one), (z2, two), F_C = whole[-1], rest[-1], self.contact.p["F_C"]
        F, N = (max(abs(what(now)) for _, now in whole) + F_C for what in (INTEGRALS["friction_impulse"], INTEGRALS["normal_impulse"]))
        rounding = 4e-16 * two.x.s1 * abs(two.x.v)  # of v - a z, which s1 magnifies
        misses = [abs(z1 - z2) * two.x.P / F, max(abs(one.F - two.F) - rounding, 0.0) / F]
        for name, scale in (("friction_impulse", F), ("normal_impulse", N)):
            what = INTEGRALS[name]
            misses.append(abs(mean(whole, what) - (mean(half, what) + mean(rest, what)) / 2) / scale * h / piece)
        return [half, rest], max(misses) / self.contact._tolerance


# ---- arithmetic: roots, linear equations, Radau collocation ---------------------------------------------------------------------------


def root(f: Callable[[float], float], low: float, high: float, resolution: float) -> tuple[float, float]:
    """Where f changes between f < 0 and f >= 0: the last values on the side of `low` and of `high`. Chandrupatla 1997.

    Without a change, twice the end at which f is nearer to 0.
    """
    a, b, f_a, f_b = high, low, f(high), f(low)  # a: newest, b: on the other side, c: the one before
    if (f_a < 0) == (f_b < 0):
        return (low, low) if abs(f_b) < abs(f_a) else (high, high)
    low_is_below, share = f_b < 0, 0.5
    while abs(b - a) > (close := max(resolution, 4.5e-16 * max(abs(a), abs(b)))):  # two units of the last place at least
        t = a + share * (b - a)
        f_t = f(t)
        if (f_t < 0) == (f_a < 0):
            c, f_c = a, f_a
        else:
            c, f_c, b, f_b = b, f_b, a, f_a
        a, f_a, share = t, f_t, 0.5
        if f_c not in (f_a, f_b):
            xi, phi = (a - b) / (c - b), (f_a - f_b) / (f_c - f_b)
            if phi * phi < xi and (1 - phi) * (1 - phi) < 1 - xi:  # inverse parabola
                share = f_a / (f_b - f_a) * f_c / (f_b - f_c) + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b)
        least = min(0.5 * close / abs(b - a), 0.5)
        share = min(max(share, least), 1 - least)
    return (a, b) if (f_a < 0) == low_is_below else (b, a)


def solve(matrix: Sequence[Sequence[Any]], right: Sequence[Any]) -> list[Any]:
    """Linear equations, by elimination with row exchange."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    for n in range(len(rows)):
        best = max(range(n, len(rows)), key=lambda i: abs(rows[i][n]))
        rows[n], rows[best] = rows[best], rows[n]
        for i, row in enumerate(rows):
            if i != n and row[n] != 0:
                factor = row[n] / rows[n][n]
                rows[i] = [value - factor * above for value, above in zip(row, rows[n], strict=True)]
    return [row[-1] / row[n] for n, row in enumerate(rows)]


def radau(stages: int) -> tuple[list[float], list[list[float]]]:
    """Nodes and matrix of the Radau IIA method of order 2 stages - 1; the last row holds the weights. Hairer and Wanner 1996, IV.5."""

    def polynomial(c: float) -> float:  # Legendre P_stages - P_(stages - 1): its zeros in (0, 1] are the nodes
        x, before, now = 2 * c - 1, 1.0, 2 * c - 1
        for n in range(1, stages):
            before, now = now, ((2 * n + 1) * x * now - n * before) / (n + 1)
        return now - before

    grid = [(1 - math.cos(math.pi * n / (8 * stages))) / 2 for n in range(8 * stages)]
    changes = [(a, b) for a, b in pairwise(grid) if (polynomial(a) < 0) != (polynomial(b) < 0)]
    nodes = [*(root(polynomial, a, b, 0.0)[1] for a, b in changes), 1.0]
    exact = [Fraction(c) for c in nodes]  # exact arithmetic: the equations for the weights are badly conditioned
    powers = [[c**n for c in exact] for n in range(stages)]
    return nodes, [[float(a) for a in solve(powers, [c ** (n + 1) / (n + 1) for n in range(stages)])] for c in exact]


NODES, MATRIX = radau(5)


def mean(nodes: Nodes, what: Callable[[Point], float]) -> float:
    """Mean over a step, by the quadrature of its nodes."""
    return math.fsum(b * what(point) for b, (_, point) in zip(MATRIX[-1], nodes, strict=True))


def collocate(rate: Callable[[int, float], float], z: float, h: float, grain: float) -> list[float]:
    """One Radau step of length h from z with dz/dt = rate(node, z): z at the nodes; empty where Newton's method finds none."""
    places, probe, before, matrix = range(len(NODES)), 1e-6 * grain, math.inf, None
    Z = [z for _ in places]
    for _ in range(30):
        dz = [rate(n, Z[n]) for n in places]
        miss = [z - Z[i] + h * sum(map(float.__mul__, MATRIX[i], dz)) for i in places]
        if not any(miss):
            return Z
        if matrix is None:
            slope = [(rate(n, Z[n] + probe) - dz[n]) / probe for n in places]
            matrix = [[(i == j) - h * MATRIX[i][j] * slope[j] for j in places] for i in places]
        move = solve(matrix, miss)
        size, scale = max(map(abs, move)), grain + max(map(abs, Z))
        if not math.isfinite(size):
            return []
        if size <= 2e-16 * scale or before <= size <= 1e-12 * scale:
            return Z
        matrix = matrix if size < 0.1 * before else None  # slow: slopes anew
        Z, before = [a + b for a, b in zip(Z, move, strict=True)], size
    return []
