"""How does a number with a unit cross the border? "30 m/min" in, SI inside, the display unit out. The one pint registry.

Arithmetic is decimal, so a micrometre is 1e-6 m to the last bit. Units fit each other where they reduce to the same base units, the radian
among them; to pint an angle is a pure number, and 60 rpm would pass for 6.28 Hz.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from evat.model import ParameterError, Variable

if TYPE_CHECKING:  # pint takes longer to load than all the rest: only where a unit is met
    import pint

# pint's name of each base unit, and what FMI and SSP call it.
BASE_UNITS = {"kilogram": "kg", "meter": "m", "second": "s", "ampere": "A", "kelvin": "K", "mole": "mol", "candela": "cd", "radian": "rad"}

SPEED_UNITS = ("m/min", "m/s")  # in which the coefficients of the paper may be read

_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_UNIT = re.compile(r"(?:1/)?\(?[A-Za-zµμ°Ω%][A-Za-zµμ°Ω%0-9_*/^. ()·-]{0,39}")
_EXAMPLES = {"1": "0.5", "m/s": "30 m/min", "m": "5 um", "Hz": "20 kHz", "rad": "45 deg", "K": "20 degC", "s": "50 us", "Pa": "400 MPa"}
_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹⋅", "-0123456789·")
_RAISED_SIGNS = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
_BARE_POWER = re.compile(r"(?<=[A-Za-zµμΩ])(-?[1-9])(?![0-9A-Za-z_.])|(?<=[A-Za-zµμΩ])(-?[1-9])(?=\.[A-Za-zµμΩ(])")
_BIG_POWER = re.compile(r"(?:\^|\*\*)\s*[-(\s]*\d{2,}")


@dataclass(frozen=True, slots=True)
class BaseUnit:
    """What a unit is in SI: value in SI = factor * value + offset, with the exponents of the base units by FMI's names."""

    exponents: dict[str, int]
    factor: Decimal
    offset: Decimal


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[Decimal]:
    import pint

    return pint.UnitRegistry(non_int_type=Decimal)


@lru_cache(maxsize=256)
def parse(unit: str) -> Any:
    """The pint unit of a unit's text; "1" has no unit, a dot multiplies ("N.s/m"), and powers may stand as people write them ("m/s2",
    "mm/s²", "kg.m2"). ParameterError where it is none."""
    if unit == "1":
        return _registry().parse_units("dimensionless")
    import pint

    problem = "no such unit"
    plain = _RAISED_SIGNS.sub(lambda match: f"^{match[0]}", unit).translate(_RAISED)
    with_powers = _BARE_POWER.sub(lambda match: f"^{match[0]}", plain)
    if _UNIT.fullmatch(plain) and not _BIG_POWER.search(plain):
        for written in dict.fromkeys((plain, with_powers)):  # some units have a digit in their names
            try:
                return _registry().parse_units(written.replace("·", "*").replace(".", "*"))
            except (pint.UndefinedUnitError, pint.DefinitionSyntaxError) as error:
                problem = str(error)
            except Exception as error:  # pint's parser raises what it likes on text that is no unit
                problem = type(error).__name__
    raise ParameterError(f"unit {unit[:40]!r}: {problem}; write it like m/min, N.s/m, um, kHz, deg or degC.")


@lru_cache(maxsize=256)
def base_unit(unit: str) -> BaseUnit:
    """`unit` by the base units of SI."""
    import pint

    parsed = parse(unit)
    zero, one = (_registry().Quantity(Decimal(number), parsed) for number in (0, 1))
    try:
        base = one.to_base_units().units
        offset, scale = zero.to(base).magnitude, one.to(base).magnitude
    except (pint.PintError, ArithmeticError, TypeError) as error:  # decibels and their like
        raise ParameterError(f"unit {unit!r} is not linear in SI units.") from error
    powers: dict[str, Any] = dict(base._units.items())
    if any(part not in BASE_UNITS or power != int(power) for part, power in powers.items()):
        raise ParameterError(f"unit {unit!r} is no product of whole powers of {', '.join(BASE_UNITS.values())}.")
    exponents = {name: int(powers[part]) for part, name in BASE_UNITS.items() if part in powers}
    return BaseUnit(exponents, scale - offset, offset)


def convert(value: Decimal, unit: BaseUnit, wanted: BaseUnit) -> float:
    """`value` from one unit to another that has the same exponents; ParameterError where no float can hold it."""
    try:
        result = float((unit.factor * value + unit.offset - wanted.offset) / wanted.factor)
    except ArithmeticError:
        result = math.inf
    if math.isinf(result):
        raise ParameterError(f"{value:.6g}: the number is too large.")
    return result


def affine(unit: str, wanted: str) -> tuple[float, float]:
    """factor and offset with value in `wanted` = factor * value in `unit` + offset; ParameterError where they measure different things."""
    source, target = base_unit(unit), base_unit(wanted)
    if source.exponents != target.exponents:
        raise ParameterError(f"{unit!r} does not measure what {wanted!r} measures.")
    return float(source.factor / target.factor), float((source.offset - target.offset) / target.factor)


def number_and_unit(text: str) -> tuple[str, str] | None:
    """The two parts of "30 m/min", as they were typed; None where it does not begin with a number."""
    match = _NUMBER.fullmatch(text)
    return None if match is None else (match[1], match[2])


def to_si(value: str | float, unit: str, *, name: str) -> float:
    """The number in `unit` (a variable's SI unit) that a user's "30 m/min" or bare number, taken as SI, stands for."""
    if not isinstance(value, str):
        return float(value)
    is_option = name.startswith("--")
    typed = f"{name} {value[:60]!r}" if is_option else f"{name} = {value[:60]!r}"
    readable = "no unit" if unit == "1" else unit
    example = _EXAMPLES.get(unit, f"1.5 {unit}")
    example = f"{name} '{example}'" if is_option else f'"{name} = {example}"'
    example = f"write for example {example}; a bare number has {readable}"
    told = number_and_unit(value)
    if told is None:
        raise ParameterError(f"{typed}: this is no number with a unit; {example}.")
    number, stated = told
    if re.match(r",\d", stated):
        raise ParameterError(f"{typed}: a decimal comma; write the number with a point. {example[:1].upper()}{example[1:]}.")
    try:
        source, target = base_unit(stated or unit), base_unit(unit)
    except ParameterError as error:
        raise ParameterError(f"{typed}: {error}") from None
    if source.exponents != target.exponents:
        raise ParameterError(f"{typed}: {stated} does not measure what {readable} measures; {example}.")
    try:
        return convert(Decimal(number), source, target)
    except (ParameterError, ArithmeticError):  # Decimal itself holds no exponent of 19 digits
        raise ParameterError(f"{typed}: the number is too large; {example}.") from None


def display(value: float, variable: Variable, *, digits: int = 6) -> str:
    """`value` (SI) of `variable` as a person reads it: in its display unit, by the name of its choice, as a whole number or a yes or no."""
    if variable.type == "choice" and 0 <= value < len(variable.choices):
        return variable.choices[int(value)]
    if variable.type == "boolean":
        return "true" if value else "false"
    if variable.type == "integer":
        return str(int(value))
    unit = variable.display_unit or variable.unit
    try:
        factor, offset = affine(variable.unit, unit)
    except ParameterError as error:
        raise ParameterError(f"variable {variable.name}, as its declaration has it: {error}") from error
    number = f"{factor * value + offset:.{digits}g}"
    return number if unit == "1" else f"{number} {unit}"
