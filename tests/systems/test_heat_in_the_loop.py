"""Does the heat of the cut set the temperature that softens the friction, and which temperature is it?"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coupled import run
from evat.model import ParameterError
from evat.native import kernel
from evat.paper.tables import materials
from evat.paper.work_materials import constants, material_of
from evat.studies.heat import HEAT, cut, proxy, steady_temperatures
from evat.systems.declared import load
from evat.systems.ssp.read import read
from evat.systems.values import of_work

AMBIENT = kernel.variable("ambient_temperature").start
PER_MINUTE = 1 / 60  # m/min in m/s


@pytest.mark.parametrize("material", materials())
def test_the_proxy_is_that_of_the_paper_s_own_tests(material: str) -> None:
    """What thermal.toml says is computed, to the digits it gives; and eq. 3's power law fits the heat of a steady cut to a fifth of the
    speed, from 1 to 60 m/min of slip."""
    given = constants(material)
    reference, exponent = proxy(material)
    assert given["reference_temperature"].value == pytest.approx(reference, abs=0.02)
    assert given["alpha_T"].value == pytest.approx(exponent, abs=2e-4)
    slips = np.array([1.0, 5.0, 20.0, 60.0]) * PER_MINUTE
    speeds = PER_MINUTE * ((steady_temperatures(material, slips) - AMBIENT) / (reference - AMBIENT)) ** (1 / exponent)
    assert speeds == pytest.approx(slips, rel=0.21)


def test_a_vibrating_tool_is_as_warm_as_its_mean_heat_makes_it_not_as_its_slip() -> None:
    """Al 6061 at 10 m/min: the slip in contact reaches 30 m/min and more, which eq. 3 with the start constants calls 683 K. But the chip
    stays for some 40 cycles of 50 us on the rake face, and its mean heat decides: 400 K if all stayed in the chip, of which the work, into
    which heat runs faster than the cut follows, keeps three quarters. So it is as warm as a steady cut at that cutting speed."""
    slip = 30 * PER_MINUTE
    start = {name: kernel.variable(name).start for name in ("theta_ref", "alpha_T", "reference_temperature")}
    by_slip = AMBIENT + (start["reference_temperature"] - AMBIENT) * (slip / start["theta_ref"]) ** start["alpha_T"]
    assert by_slip == pytest.approx(683, abs=1)
    vibrating, still = cut("al-6061", 10 * PER_MINUTE), cut("al-6061", 10 * PER_MINUTE, {"amplitude_x": 0.0, "amplitude_y": 0.0})
    assert vibrating.contact_temperature == pytest.approx(369, abs=3)
    assert vibrating.contact_temperature == pytest.approx(still.contact_temperature, abs=8)
    work = constants("al-6061")["work_heat_capacity"].value * 1e-3 * 1e-4 * 10 * PER_MINUTE
    adiabatic = (vibrating.shear_power + vibrating.dissipated_power) / work
    assert vibrating.contact_temperature - AMBIENT < 0.3 * adiabatic


def test_eq_3_with_the_heat_of_the_cut_reaches_683_kelvin_when_that_fast() -> None:
    """It is the temperature of a far faster cut of aluminium: 683 K are those of some 110 m/min of slip."""
    low, high = (cut("al-6061", v, {"amplitude_x": 0.0, "amplitude_y": 0.0}).contact_temperature for v in (3.0, 4.0))
    assert low < 683 < high


def turning(path: Path, speed: float, softening: bool, stop: float = 6e-3) -> dict[str, float]:
    """Means over the last cycles of the coupled cut of Al 6061; temperature and speed at the end."""
    system = read(path, path.parent / f"read-{speed}-{softening}")
    values = of_work(system, "contact", "regularised/al-6061")
    values["contact"]["thermal_softening"] = softening
    rate = speed / 0.02  # rad/s at the radius of the work
    values["spindle"] = dict.fromkeys(("speed_set", "spindle_speed", "speed_reference"), rate)
    trace, _ = run(path, values, stop=stop)
    late = trace.times > 0.9 * stop
    return {name: float(np.mean(trace[name][late])) for name in trace.columns}


def test_softening_changes_the_thrust_where_the_cut_is_hot(systems: dict[str, Path]) -> None:
    """Al 6061 in the machine. At 10 m/min the contact is at 369 K, which stands for 6 m/min: no softening, as in a steady test that slow.
    At 75 m/min, HSR 2, it is at 500 K: the bristles are soft, and the thrust is another."""
    path, thrust = systems["evat_turning"], "contact.mean_feed_force"
    for speed, bounds in ((10 * PER_MINUTE, (0.0, 0.01)), (75 * PER_MINUTE, (0.1, 2.0))):
        with_it, without = (turning(path, speed, softening) for softening in (True, False))
        changed = abs(with_it[thrust] - without[thrust]) / abs(without[thrust])
        assert bounds[0] <= changed <= bounds[1], (speed, changed)
        expected = cut("al-6061", speed)
        assert with_it["heat.contact_temperature"] == pytest.approx(expected.contact_temperature, abs=12)  # the tool gives way


def test_a_material_brings_its_heat_along(systems: dict[str, Path], tmp_path: Path) -> None:
    system = read(systems["evat_turning"], tmp_path)
    values = of_work(system, "contact", "regularised/inconel-718")
    known = constants("inconel-718")
    assert values["heat"] == {name: known[name].value for name in HEAT}
    assert values["contact"]["alpha_T"] == known["alpha_T"].value
    assert values["contact"]["F_C"] == 0.7379
    assert "alpha_T" not in of_work(system, "contact", "lugre-1995")["contact"]
    assert material_of("lugre-1995") is None
    with pytest.raises(ParameterError, match="no material 'brass'"):
        constants("brass")


def test_the_system_declares_its_own_material_in_both_parts() -> None:
    declared = load("evat_turning")
    known = constants("al-7075-t6")
    for part, name in (("heat", "work_conductivity"), ("contact", "reference_temperature")):
        assert declared.parts[part].values[name] == known[name].value
        assert declared.parts[part].sources[name] == known[name].source
