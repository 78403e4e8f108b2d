"""How warm does the contact get, and which slip speed does that temperature stand for? The heat of a cut in steady state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from evat import parameter_sets
from evat.model import FloatArray
from evat.native import kernel
from evat.native.kernel import Contact
from evat.native.machine import Machine
from evat.paper.work_materials import constants

SLIP = (1 / 60, 1.0)  # m/s: where the proxy is fitted, 1 to 60 m/min
CYCLES = 600  # of the vibration, after which bristles that heat has softened have come to their end, too
SETTLED = 0.05  # s: contact and chip have settled, the insert has hardly warmed
HEAT = ("work_conductivity", "work_heat_capacity")


@dataclass(frozen=True, slots=True)
class Cut:
    """What a cut comes to: temperatures [K], powers [W] and forces [N], means over the vibration cycle."""

    contact_temperature: float
    bulk_temperature: float
    flash_temperature: float
    work_share: float
    dissipated_power: float
    shear_power: float
    principal_force: float
    feed_force: float


def cut(material: str, cutting_speed: float, values: Mapping[str, float | str] | None = None, softening: bool = True) -> Cut:
    """A cut of the paper's law, `regularised/<material>`, whose temperature proxy is its slip speed, with the heat that it makes.

    values : of the contact, beside those of the set; amplitude_x and amplitude_y 0 for conventional turning.
    softening : whether the effects of the set are on.
    """
    law = parameter_sets.load(f"regularised/{material}")
    given = {**law.by_choice, "cutting_speed": cutting_speed, **(values or {})}
    contact = Contact(given, law.effects if softening else ())
    contact.start()
    contact.advance(CYCLES / contact.get("vibration_frequency"))
    shared = ("width", "feed", "chip_flow_shear_angle", "rake_angle", "ambient_temperature", "cutting_speed")
    powers = {name: contact.get(f"mean_{name}") for name in ("dissipated_power", "shear_power")}
    known = {name: constants(material)[name].value for name in HEAT}
    heat = Machine("tool_heat", {**{name: contact.get(name) for name in shared}, **known, **powers})
    heat.start()
    heat.advance(SETTLED)
    warm = (heat.get(name) for name in ("contact_temperature", "bulk_temperature", "flash_temperature", "work_share"))
    forces = (contact.get(f"mean_{name}") for name in ("principal_force", "feed_force"))
    return Cut(*warm, *powers.values(), *forces)


def steady_temperatures(material: str, slips: FloatArray) -> FloatArray:
    """Temperature of the contact [K] in conventional turning at slip speeds [m/s]."""
    angle = kernel.variable("chip_flow_shear_angle").start
    still: dict[str, float | str] = {"amplitude_x": 0.0, "amplitude_y": 0.0}
    return np.array([cut(material, slip / np.tan(angle), still).contact_temperature for slip in slips])


def proxy(material: str) -> tuple[float, float]:
    """reference_temperature [K] at theta_ref = 1 m/min and alpha_T: the line through the steady temperatures, on logarithmic scales."""
    slips = np.geomspace(*SLIP, 13)
    rise = steady_temperatures(material, slips) - kernel.variable("ambient_temperature").start
    exponent, level = np.polyfit(np.log(slips / SLIP[0]), np.log(rise), 1)
    return float(kernel.variable("ambient_temperature").start + np.exp(level)), float(exponent)
