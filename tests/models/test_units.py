"""Does a number with a unit mean at the border what a person means by it, and is a wrong dimension refused?"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import replace

import pytest
from evat.model import ParameterError
from evat.native import kernel
from evat.units import affine, base_unit, display, to_si
from hypothesis import given
from hypothesis import strategies as st


# Exact by definition of the units; the result is the nearest double, so no tolerance.
@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("30 m/min", "m/s", 0.5),
        ("5 um", "m", 5e-6),
        ("5 µm", "m", 5e-6),
        ("20 kHz", "Hz", 20e3),
        ("45 deg", "rad", math.pi / 4),
        ("20 degC", "K", 293.15),
        ("68 degF", "K", 293.15),
        ("20 degC", "degF", 68.0),
        ("400 MPa", "Pa", 4e8),
        ("1.5 N/um", "N/m", 1.5e6),
        ("2 N/(m/min)", "N.s/m", 120.0),
        ("7 N.s/m", "N.s/m", 7.0),
        ("5 %", "1", 0.05),
        ("-.5e1mm", "m", -0.005),
        (" 3 ", "m", 3.0),
        ("3 m/s2", "m/s^2", 3.0),
        ("3 mm/s²", "m/s^2", 0.003),
        ("3 mm·s⁻²", "m/s^2", 0.003),
        ("3 m.s-2", "m/s^2", 3.0),
        ("3 kg.m2", "kg.m^2", 3.0),
        ("3 kg.m2/s", "kg.m^2/s", 3.0),
        ("3 m2.kg", "kg.m^2", 3.0),
        ("3 N.s2/m2", "kg/m", 3.0),
        ("3 N/mm2", "Pa", 3e6),
        ("120 min-1", "Hz", 2.0),
        ("1 inH2O", "inH2O", 1.0),
        ("1e-3", "m/s", 1e-3),
        (2, "m/s", 2.0),
        (0.1, "N", 0.1),
    ],
)
def test_what_is_typed_is_what_is_meant(text: str | float, unit: str, number: float) -> None:
    assert to_si(text, unit, name="x") == number


@pytest.mark.parametrize(
    ("text", "unit", "complaint"),
    [
        ("30 N", "m/s", "v = '30 N': N does not measure what m/s measures; .*v = 30 m/min"),
        ("60 rpm", "Hz", "rpm does not measure what Hz measures; .*20 kHz"),  # 60 rpm is 6.28 rad/s, not 6.28 Hz
        ("0,1 s", "s", "v = '0,1 s': a decimal comma; write the number with a point. Write for example .*50 us"),
        ("3 rad", "1", "rad does not measure what no unit measures"),
        ("5 dB", "1", "not linear"),
        ("5 furlongs per fortnight!", "m/s", "no such unit"),
        ("5 __import__('os')", "m", "no such unit"),
        ("5 m**999999999", "m", "no such unit"),
        ("5 m⁹⁹⁹", "m", "no such unit"),
        ("5 m99", "m", "unit 'm99'"),
        ("5 m22/s", "m", "unit 'm22/s'"),
        ("5 m^9^9^9", "m", "unit 'm"),
        ("5 (((", "m", "no such unit"),
        ("fast", "m/s", "no number with a unit"),
        ("nan", "m/s", "no number with a unit"),
        ("", "m/s", "no number with a unit"),
        ("1e400 m/s", "m/s", "too large"),
        ("1e99999999999999999999 m", "m", "too large"),
    ],
)
def test_what_means_nothing_is_refused_with_an_example(text: str, unit: str, complaint: str) -> None:
    with pytest.raises(ParameterError, match=complaint):
        to_si(text, unit, name="v")


@given(st.text(max_size=60))
def test_no_text_brings_the_parser_down(text: str) -> None:
    with suppress(ParameterError):
        assert math.isfinite(to_si("1 " + text, "m/s", name="x"))


@pytest.mark.parametrize("variable", kernel.variables(), ids=lambda variable: variable.name)
def test_every_unit_of_the_tables_is_si_and_its_display_unit_fits(variable: kernel.Variable) -> None:
    base = base_unit(variable.unit)
    assert (base.factor, base.offset) == (1, 0)
    factor, _ = affine(variable.unit, variable.display_unit or variable.unit)
    assert factor > 0


def test_base_units_carry_what_fmi_writes() -> None:
    assert base_unit("N.s/m").exponents == {"kg": 1, "s": -1}
    assert base_unit("rad").exponents == {"rad": 1}
    assert base_unit("1").exponents == {}
    celsius = base_unit("degC")
    assert (celsius.exponents, float(celsius.factor), float(celsius.offset)) == ({"K": 1}, 1.0, 273.15)


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("cutting_speed", 0.5, "30 m/min"),
        ("amplitude_x", 5e-6, "5 um"),
        ("contact_temperature", 293.15, "20 degC"),
        ("damping_margin", 0.25, "0.25"),
        ("sigma2", 1.5, "1.5 N.s/m"),
        ("friction_law", 0.0, "coulomb"),
        ("thermal_damping", 1.0, "true"),
        ("step_count", 12.0, "12"),
    ],
)
def test_a_person_reads_it_in_the_display_unit(name: str, value: float, text: str) -> None:
    variable = kernel.variable(name)
    assert display(value, variable) == text
    if variable.type == "real":
        assert to_si(text, variable.unit, name=name) == pytest.approx(value, rel=1e-15)


def test_a_unit_that_a_declaration_has_and_that_is_none_names_the_variable() -> None:
    variable = replace(kernel.variable("sigma2"), name="air_drag.c", unit="N.x2")
    with pytest.raises(ParameterError, match=r"variable air_drag.c, as its declaration has it: unit 'N.x2'"):
        display(1.0, variable)
