"""What does a column hold, by its name and its unit? Words of laboratories in some languages; the unit has the last word."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, get_args

from evat.files.spelling import split_header, unit_meant
from evat.units import base_unit

Kind = Literal[
    "time", "velocity", "position", "force", "normal_load", "principal_force", "feed_force", "current", "torque", "temperature",
    "cutting_speed", "feed", "width", "uncut_thickness", "trigger", "deviation", "coefficient",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)

# Whole words and beginnings of words (ending in *); the longest that fits decides, so that "normal force" is no friction
# force, and of equally long ones the first. What is written without blanks, Chinese and Japanese, may stand anywhere in a name.
WORDS: Mapping[Kind, str] = {
    "time": "t time zeit* uhrzeit temps tiempo tempo tijd tid czas cas timestamp elapsed clock время 时间 時間 abtastzeit x_value",
    "velocity": (
        "v vel velocity velocities speed geschw* gleitgeschw* drehzahl* vitesse* velocidad velocita snelheid "
        "hastighet predkosc rychlost slip_velocity sliding_speed sliding_velocity belt_speed rpm omega n скорость "
        "速度 转速 回転数 回転速度 vrel v_rel"
    ),
    "position": (
        "x s pos position* weg displacement* disp stroke travel way hub lage encoder posicion posizione "
        "deplacement* desplazamiento spostamento q qm angle* winkel* drehwinkel* phi angulo angolo положение 位置 "
        "位移 変位 角度 verschiebung"
    ),
    "normal_load": (
        "fn f_n normal* normalkraft* normal_force normal_load anpress* load last charge carga carico pruefkraft prufkraft axialkraft* "
        "axial_force axial_load 法向力 荷重 載荷 载荷 垂直荷重 法線力"
    ),
    "principal_force": (
        "fc f_c cutting_force* schnittkraft* hauptkraft principal_force main_force effort_de_coupe fuerza_de_corte tangential_force_cut"
    ),
    "feed_force": "ff f_f feed_force* vorschubkraft* effort_d_avance fuerza_de_avance thrust*",
    "force": (
        "f force* kraft* reibkraft* reibungskraft* friction* reibung* frottement* effort* fuerza* forza* forca "
        "friccion attrito kracht sila ft f_t ffr fr f_r fric tangential* tangentiel* tangenzial* сила 力 摩擦力 friction_force friction_n"
    ),
    "current": "i iq i_q current* strom* motorstrom* motor_current courant* corriente corrente stroom ток 电流 電流",
    "torque": "torque* moment* drehmoment* couple* par coppia motor_torque m_motor момент 转矩 トルク",
    "temperature": "temp temperature* temperatur* temperatura* theta 温度",
    "cutting_speed": "vc v_c cutting_speed schnittgeschw* vitesse_de_coupe velocidad_de_corte",
    "feed": "f fz f_z feed vorschub avance avanzamento",
    "width": "width breite schnittbreite ap a_p b largeur ancho doc",
    "uncut_thickness": "h thickness uncut_thickness spanungsdicke chip_thickness",
    "trigger": "trigger trig gate marker",
    "deviation": "std sd stdev sigma streuung stabw standardabweichung ecart",
    "coefficient": (
        "cof mu µ friction_coefficient coefficient_of_friction coeff_of_friction reibwert* reibungszahl* reibungskoeffizient* "
        "reibbeiwert* coefficient_de_frottement coeficiente_de_friccion coefficiente_di_attrito 摩擦係数 摩擦系数"
    ),
}
_OF_UNIT: Mapping[Kind, tuple[str, ...]] = {
    "time": ("s",),
    "velocity": ("m/s", "rad/s"),
    "position": ("m", "rad"),
    "force": ("N", "V"),
    "normal_load": ("N",),
    "principal_force": ("N",),
    "feed_force": ("N",),
    "current": ("A",),
    "torque": ("N.m",),
    "temperature": ("K",),
    "cutting_speed": ("m/s",),
    "feed": ("m",),
    "width": ("m",),
    "uncut_thickness": ("m",),
    "trigger": ("1", "V"),
    "deviation": ("N",),
    "coefficient": ("1",),
}
_FIRST_UNSPACED = "\u3040"  # kana and ideographs begin here
_COMMANDED = re.compile(r"\b(soll|set|setpoint|ref|reference|cmd|command|commanded|target|consigne|desired|demand|nom|nominal)\b")


@dataclass(frozen=True, slots=True)
class Meant:
    """A column: its header, the unit that it states ("" where none), what it holds ("" where that is not told), by which word, and
    whether it is what was asked of a controller and not what was measured."""

    header: str
    unit: str
    kind: Kind | Literal[""]
    word: str
    commanded: bool = False


def meant(header: str, below: str = "", given: str = "") -> Meant:
    """What a header says with the line of units below it, and a unit that was given for it."""
    name, unit = split_header(header)
    unit = given or (unit_meant(below) if below else None) or unit or ""
    flat = plain(name)
    kind, word = _by_words(flat, unit)
    if not kind and unit == "s" and not given and not below and header.strip()[-1:] not in ("]", ")", "}", ">"):
        kind, word = _by_words(flat, "")  # "v_s" is a name
        unit = "" if kind else unit
    if not kind and unit and not word:
        kind = next((each for each in KINDS if fits(each, unit) and each not in ("deviation", "trigger", "coefficient")), "")
    return Meant(header, unit, kind, word, bool(_COMMANDED.search(flat.replace("_", " "))))


def fits(kind: Kind, unit: str) -> bool:
    """Whether a unit measures such a thing."""
    return any(base_unit(unit).exponents == base_unit(each).exponents for each in _OF_UNIT[kind])


def plain(text: str) -> str:
    """In small letters without accents, its words joined by underscores."""
    letters = unicodedata.normalize("NFKD", text.lower().replace("ß", "ss"))
    return re.sub(r"[\W_]+", "_", "".join(each for each in letters if not unicodedata.combining(each))).strip("_")


def _by_words(flat: str, unit: str) -> tuple[Kind | Literal[""], str]:
    best: tuple[int, Kind | Literal[""], str] = (0, "", "")
    for kind, words in WORDS.items():
        if unit and not fits(kind, unit):
            continue
        for word in words.split():
            stem = plain(word.rstrip("*"))
            if len(stem) > best[0] and _stands_in(stem, flat, begins=word.endswith("*")):
                best = (len(stem), kind, word.rstrip("*"))
    deviation = any(re.search(rf"(?:^|_){word}(?:_|$)", flat) for word in WORDS["deviation"].split())
    return ("deviation", "") if deviation else best[1:]


def _stands_in(stem: str, flat: str, *, begins: bool) -> bool:
    if stem >= _FIRST_UNSPACED:
        return stem in flat
    return re.search(rf"(?:^|_){re.escape(stem)}{'' if begins else r'(?:_|$|(?=[0-9]))'}", flat) is not None
