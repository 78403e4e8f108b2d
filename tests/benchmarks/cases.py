"""Which motions do all solvers compete on? A sinusoid of slip, and the cuts of an ellipse: the right-hand side once for Python, once for
CVode, once as values of the kernel, and the bristle deflection to 12 digits."""

from __future__ import annotations

import ctypes as ct
import functools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from evat import parameter_sets
from evat.model import FloatArray
from evat.native import kernel
from evat.native.kernel import Contact
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

FREQUENCY = 20e3  # Hz
OMEGA, PERIOD = 2 * math.pi * FREQUENCY, 1 / FREQUENCY
CYCLES = 4
CHECKS = 200  # instants a cycle at which the error is looked at


class LawInC(ct.Structure):
    """struct Law of loops.c."""

    _fields_ = [(name, ct.c_double) for name in ("mean", "cosine", "sine", "omega", "P", "F_C", "F_S", "v_s")] + [("data", ct.c_void_p)]


@dataclass(frozen=True)
class Case:
    """Slip v = mean + cosine cos(w t) + sine sin(w t) on a LuGre bristle that begins each of `spans` unloaded.

    A span is what a solver is given in one piece. Of a cut it is told entry and exit, which the kernel has to find itself.
    """

    name: str
    mean: float
    cosine: float
    sine: float
    law: tuple[float, float, float, float]  # P, F_C, F_S, v_s
    spans: tuple[tuple[float, float], ...]
    values: dict[str, float | str]  # of the kernel's contact
    start: float  # time at which the kernel starts [s]

    @property
    def scale(self) -> float:
        """What z is at most [m]."""
        P, F_C, F_S, _ = self.law
        return max(F_C, F_S) / P

    def slip(self, t: float) -> float:
        return self.mean + self.cosine * math.cos(OMEGA * t) + self.sine * math.sin(OMEGA * t)

    def rate(self) -> Callable[[float, FloatArray], list[float]]:
        """dz/dt(t, z) as a user of scipy writes it, in a form that Python is quick with."""
        (P, F_C, F_S, v_s), mean, cosine, sine = self.law, self.mean, self.cosine, self.sine
        cos, sin, exp = math.cos, math.sin, math.exp

        def rate(t: float, z: FloatArray) -> list[float]:
            v = mean + cosine * cos(OMEGA * t) + sine * sin(OMEGA * t)
            return [v - P * abs(v) / (F_C + (F_S - F_C) * exp(-((v / v_s) ** 2))) * z[0]]

        return rate

    def in_c(self) -> LawInC:
        return LawInC(self.mean, self.cosine, self.sine, OMEGA, *self.law)

    def checks(self, span: tuple[float, float]) -> FloatArray:
        """Instants within a span at which the error is looked at; at its end the bristle may have been let go already."""
        count = round(CHECKS * (span[1] - span[0]) / PERIOD)
        return np.linspace(*span, max(count, CHECKS) + 1)[1:-1]

    @functools.cached_property
    def truth(self) -> list[FloatArray]:
        """z at the checks of each span: Radau, rtol 1e-12, in pieces from one reversal of the slip to the next."""
        rows, rate = [], self.rate()
        for span in self.spans:
            grid, z, pieces = np.linspace(*span, 64 * CYCLES + 1), 0.0, [span[0]]
            slips = [self.slip(t) for t in grid]
            pieces += [
                float(brentq(self.slip, a, b, xtol=1e-20))
                for a, b, v, w in zip(grid, grid[1:], slips, slips[1:], strict=False)
                if v * w < 0 and a > span[0]
            ]
            checks, row = self.checks(span), np.empty(0)
            for begin, end in zip(pieces, [*pieces[1:], span[1]], strict=True):
                inside = checks[(checks > begin) & (checks <= end)]
                out = np.union1d(inside, [end])
                done = solve_ivp(rate, (begin, end), [z], "Radau", t_eval=out, rtol=1e-12, atol=1e-12 * self.scale)
                z, row = done.y[0, -1], np.append(row, done.y[0, : inside.size])
            rows.append(row)
        return rows

    def error(self, rows: list[FloatArray]) -> float:
        """Largest error of z over all checks, relative to its largest value."""
        true, other = np.concatenate(self.truth), np.concatenate(rows)
        return float(np.max(np.abs(other - true)) / np.max(np.abs(true)))

    def contact(self, tolerance: float) -> Contact:
        contact = Contact({**self.values, "relative_tolerance": tolerance})
        contact.start(self.start)
        return contact

    def of_kernel(self, tolerance: float) -> list[FloatArray]:
        """z at the checks, each reached in one communication step from the start of its span's cycle: the steps of an unbroken run."""
        contact, rows = self.contact(tolerance), []
        for span in self.spans:
            before, row = contact.state(), []
            for t in self.checks(span):
                contact.restore(before)
                contact.advance(t - contact.time)
                row.append(contact.get("bristle_deflection"))
            rows.append(np.array(row))
            contact.restore(before)
            contact.advance(PERIOD * round((span[1] - contact.time) / PERIOD))
        return rows


def _law(set_name: str) -> tuple[tuple[float, float, float, float], dict[str, float | str]]:
    values = parameter_sets.load(set_name).values
    P, F_C, F_S, v_s = (float(values[name]) for name in ("sigma0", "F_C", "F_S", "v_s"))
    return (P, F_C, F_S, v_s), {"sigma0": P, "F_C": F_C, "F_S": F_S, "v_s": v_s, "sigma2": float(values["sigma2"]), "sigma1": 0.0}


def sinusoid(set_name: str) -> Case:
    """Slip to and fro with 5 um in an unbroken contact: an ellipse without its half along the cutting direction."""
    law, values = _law(set_name)
    amplitude = kernel.variable("amplitude_y").start
    flow = kernel.variable("chip_flow_shear_angle").min
    crawl = 1e-9  # m/s; in contact is what moves into the material
    values |= {"amplitude_x": 0.0, "phase_y": 0.0, "cutting_speed": crawl, "chip_flow_shear_angle": flow}
    return Case(
        name=f"sinusoid, {set_name}",
        mean=crawl * math.tan(flow),
        cosine=0.0,
        sine=amplitude * OMEGA,
        law=law,
        spans=((0.0, CYCLES * PERIOD),),
        values=values,
        start=0.0,
    )


def ellipse(set_name: str) -> Case:
    """The cuts of the component's own start values: 20 kHz, 5 um by 5 um, 10 m/min, the nominal surface far above."""
    law, values = _law(set_name)
    a, v_c = kernel.variable("amplitude_x").start, kernel.variable("cutting_speed").start
    flow, r = math.tan(kernel.variable("chip_flow_shear_angle").start), v_c / (a * OMEGA)
    entry = brentq(lambda s: r * (math.pi - s) - math.sin(s), 1e-6, math.pi * (1 - r), xtol=1e-15)  # before the bottom of the path
    cuts = [(PERIOD * n - entry / OMEGA, PERIOD * n + math.acos(-r) / OMEGA) for n in range(1, CYCLES + 1)]
    return Case(
        name=f"ellipse, {set_name}",
        mean=v_c * flow,
        cosine=a * OMEGA * flow,
        sine=-kernel.variable("amplitude_y").start * OMEGA,
        law=law,
        spans=tuple(cuts),
        values=values,
        start=0.5 * PERIOD,
    )
