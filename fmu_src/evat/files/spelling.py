"""Which unit is meant by what stands in a header? The spellings of laboratories and measuring programs, in some languages."""

from __future__ import annotations

import re

# What is meant, and how it is written beside that; upper and lower case count only where both are units.
SPELLINGS = {
    "s": "sec secs second seconds sek sekunde sekunden seg segundos seconde secondes sn с 秒",
    "ms": "msec millisec milliseconds millisekunden мс 毫秒",
    "us": "usec microsec microseconds мкс",
    "min": "minute minutes minuten",
    "m": "meter metre meters metres м",
    "mm": "millimeter millimetre millimeters мм 毫米",
    "um": "micron microns micrometer micrometre mikrometer мкм",
    "nm": "nanometer",
    "cm": "centimeter",
    "in": "inch inches",
    "m/s": "mps m/sec m/sek m.s-1 м/с",
    "mm/s": "mmps mm/sec mm/sek mm.s-1 мм/с",
    "um/s": "um/sec um.s-1",
    "m/min": "mpm m.min-1 м/мин",
    "mm/min": "mmpm mm.min-1",
    "rad": "radian radians",
    "deg": "grad degree degrees degre degres grados gradi ° град",
    "rad/s": "rad/sec rad.s-1",
    "deg/s": "°/s grad/s deg/sec °/sec deg.s-1",
    "rpm": "u/min 1/min min-1 min^-1 tr/min r/min upm rev/min 1/мин об/мин",
    "N": "newton newtons н",
    "kN": "kilonewton кн",
    "mN": "millinewton",
    "uN": "mikronewton micronewton",
    "daN": "dekanewton",
    "lbf": "lbs",
    "N.m": "nm n*m newtonmeter newton.meter н.м",
    "mN.m": "mnm",
    "N.mm": "nmm n*mm",
    "N.cm": "ncm",
    "A": "amp amps ampere amperes а",
    "mA": "milliampere",
    "V": "volt volts",
    "mV": "millivolt",
    "degC": "°c celsius ºc c grad.c",
    "K": "kelvin",
    "MPa": "n/mm2 n/mm^2",
    "Hz": "hertz гц",
    "kHz": "",
    "1": "- -- 1 count counts",
    "%": "percent prozent",
}
_EXACT = {unit: unit for unit in SPELLINGS} | {"Nm": "N.m", "mNm": "mN.m", "Nmm": "N.mm", "Ncm": "N.cm", "nm": "nm"}
_ANY_CASE = {word: unit for unit, words in SPELLINGS.items() for word in (*words.split(), unit.lower())} | {
    "s": "s",
    "mn": "mN",
    "nm": "N.m",
}
_SUFFIX = re.compile(
    r"^(?P<name>.*?[^\W_].*?)(?:\s+in\s+|\s*[_,;/|:.]\s*|\s+)(?P<unit>[^\s_,;|:]+(?:(?:[_ ](?:per[_ ])?|/)(?:s|sec|min))?)$"
)


def unit_meant(text: str) -> str | None:
    """The unit by the name that the readers of this package take; None where it is no unit that is known here."""
    tidy = text.strip().translate(str.maketrans("µμ·⋅⁻¹²º", "uu..-12°"))
    tidy = re.sub(r"(?:_per_|[ _]per[ _]|\s*/\s*|_(?=(?:s|sec|min)$))", "/", tidy)
    tidy = re.sub(r"\s+", ".", tidy)
    return _EXACT.get(tidy) or _ANY_CASE.get(tidy.lower())


def split_header(header: str) -> tuple[str, str | None]:
    """Name and unit of a header such as "F [N]", "v in mm/s", "F / N", "Zeit_ms"; None where it states no unit that is known."""
    text = header.strip().lstrip("#").strip()
    match = re.fullmatch(r"(?P<name>.*?)\s*[\[(<{](?P<unit>[^][(){}<>]*(?:\([^()]*\))?[^][(){}<>]*)[\])>}]\s*", text)
    if match:
        return match["name"].strip(" _,;:/"), unit_meant(match["unit"])
    match = _SUFFIX.match(text)
    if match and (unit := unit_meant(match["unit"])) is not None and unit != "1":
        return match["name"].strip(" _,;:/"), unit
    return text, None
