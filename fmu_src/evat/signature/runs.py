"""Which runs show an effect? A vibration cycle, and slip on a rig: to and fro, steady, after a rest, for long; for one set of values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.model import FloatArray
from evat.native import kernel
from evat.native.kernel import Contact

FORCES = ("measured_friction_force", "measured_principal_force", "measured_feed_force")
PROXY = "theta_used"  # what an effect changes that acts on the temperature alone
RECORDED = (*FORCES, PROXY)
MEANS = (*(f"mean_{force}" for force in FORCES), "mean_contact_ratio")
CYCLE_SAMPLES = 400
DECADES = np.geomspace(1e-4, 1, 25)  # of speeds and frequencies that a sweep covers


@dataclass(frozen=True, slots=True)
class Axis:
    """What an axis shows: words, SI unit, the unit in which people read it, and whether it is logarithmic."""

    name: str
    unit: str
    display_unit: str
    logarithmic: bool = False

    @classmethod
    def of(cls, name: str, *, logarithmic: bool = False) -> Axis:
        """The axis of a variable of the component."""
        variable = kernel.variable(name)
        return cls(name, variable.unit, variable.display_unit or variable.unit, logarithmic)


@dataclass(frozen=True, slots=True)
class Case:
    """Values of the component, switches among them; and the scales of its motion that follow from them."""

    values: Mapping[str, float]

    def __getitem__(self, name: str) -> float:
        return self.values.get(name, kernel.variable(name).start)

    def but(self, **values: float | str) -> Case:
        return Case({**self.values, **kernel.check_values(values)})

    @property
    def period(self) -> float:
        return 1 / self["vibration_frequency"]

    @property
    def fastest(self) -> float:
        """Speed amplitude of the ellipse along the cut, or the cutting speed where nothing vibrates [m/s]."""
        return 2 * np.pi * self["vibration_frequency"] * self["amplitude_x"] or self["cutting_speed"]

    @property
    def reach(self) -> float:
        """Deflection at which the bristles yield [m]."""
        return max(self["F_C"], self["F_S"]) / self["sigma0"]

    @property
    def speed(self) -> float:
        """A slip well above the Stribeck velocity [m/s]."""
        return 10 * self["v_s"]

    def on_ellipse(self, initial_state: str = "periodic", window: float = 0.0) -> Case:
        return self.but(kinematics="internal", initial_state=initial_state, averaging_window=window)

    def carried(self, window: float) -> Case:
        return self.but(kinematics="combined", initial_state="at_rest", averaging_window=window)

    def on_rig(self, window: float = 0.0) -> Case:
        return self.but(kinematics="external", initial_state="at_rest", averaging_window=window)

    def run(self, times: FloatArray, names: Sequence[str], **columns: FloatArray) -> dict[str, FloatArray]:
        contact = Contact({**self.values, **{name: float(column[0]) for name, column in columns.items()}})
        contact.start(float(times[0]))
        return dict(zip(names, contact.run(times, columns, names).T, strict=True))


def one_cycle(case: Case) -> tuple[FloatArray, dict[str, FloatArray]]:
    """What is recorded over one vibration cycle of the periodic steady state."""
    clock = np.linspace(0, case.period, CYCLE_SAMPLES + 1)
    return clock, case.on_ellipse().run(clock, RECORDED)


def to_and_fro(case: Case, amplitude: float | None = None, frequency: float | None = None) -> dict[str, FloatArray]:
    """The second cycle of a sinusoidal slip: what is recorded, `slip` [m], and `energy` taken from the motion in the cycle [J]."""
    a = 10 * case.reach if amplitude is None else amplitude
    f = case.speed / (2 * np.pi * a) if frequency is None else frequency
    times = np.arange(2 * CYCLE_SAMPLES + 1) / (CYCLE_SAMPLES * f)
    v = 2 * np.pi * f * a * np.cos(2 * np.pi * f * times)
    columns = {name: column[CYCLE_SAMPLES:] for name, column in case.on_rig().run(times, RECORDED, slip_velocity=v).items()}
    columns["slip"] = a * np.sin(2 * np.pi * f * times[CYCLE_SAMPLES:])
    columns["energy"] = np.array(np.mean((columns[FORCES[0]] * v[CYCLE_SAMPLES:])[:-1]) / f)
    return columns


def cycle_means(case: Case) -> list[float]:
    columns = case.on_ellipse().run(case.period * np.array([0, 1, 1.5]), MEANS)
    return [float(columns[name][-1]) for name in MEANS]


def steady(case: Case) -> list[float]:
    """What is recorded once slip at a constant speed has renewed all bristles; after one time for all speeds."""
    slowest = 100 * case.speed * DECADES[0]
    columns = case.on_rig().run(np.array([0, 20 * case.reach / slowest]), RECORDED)
    return [float(columns[name][-1]) for name in RECORDED]


def loop(case: Case, amplitude: float, frequency: float) -> list[float]:
    columns = to_and_fro(case, amplitude, frequency)
    return [float(np.max(np.abs(columns[FORCES[0]]))), float(columns["energy"])]


def peak_after_rest(case: Case, rest: float) -> list[float]:
    """Slide, so slowly that static friction counts, rest, slide again: the largest force at the second start."""
    v = 0.01 * case.speed
    long = 20 * case.reach / v
    ramp = 1e-3 * long
    again = long + 2 * ramp + rest
    times = np.concatenate([[0, long, long + ramp, long + ramp + rest], again + np.linspace(0, long, CYCLE_SAMPLES)])
    slip = np.full(times.size, v)
    slip[2:4] = 0
    return [float(np.max(np.abs(case.on_rig().run(times, FORCES, slip_velocity=slip)[FORCES[0]][4:])))]


def means_over_time(case: Case, window: float, count: int, carried: float = 0.0) -> dict[Axis, FloatArray]:
    """Means over each of `count` windows after the first, in which the run starts; a machine carries the tool away from the surface and
    back, six and a half times, by `carried` [m]. Read in the middle of the next window, so that no rounding of the clock decides which."""
    times = window * np.concatenate([[0], np.arange(2, count + 2) + 0.5])
    columns: dict[str, FloatArray] = {}
    if carried:
        omega = 2 * np.pi * 6.5 / (window * count)
        columns["tool_displacement_y"] = carried * np.sin(omega * times)
        columns["tool_velocity_y"] = carried * omega * np.cos(omega * times)
    return {Axis.of(name): column[1:] for name, column in case.run(times, MEANS, **columns).items()}
