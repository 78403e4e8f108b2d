"""What can a case be made of, and which part of it is kept back? Effects by family and world, base laws, unknown kinds, their splits."""

from __future__ import annotations

from dataclasses import dataclass

from . import effects_of_cutting, effects_of_measurement  # noqa: F401  their forms are entered on import
from .effects_of_friction import FORMS, Maker
from .unknowns import KINDS

SPLITS = ("development", "kept")
STRATA = {"small": (0.3, 1.0), "medium": (1.0, 3.0), "large": (3.0, 10.0)}  # structural rms over the noise of one recording
TIMES = {"small": 1, "medium": 2, "large": 2}  # that each comes in a round: the proof counts the two larger ones
SHARES = {"single": 0.40, "pair": 0.14, "none": 0.16, "mistuned": 0.12, "unknown": 0.18}
WORLDS = {"rig": 0.4, "axis": 0.2, "ellipse": 0.25, "means": 0.15}


@dataclass(frozen=True)
class Kind:
    """An effect of the library: its family, the worlds it can be seen in, and what a record must have."""

    family: str
    worlds: tuple[str, ...]
    needs: tuple[str, ...] = ()


_R, _A, _E, _M = "rig", "axis", "ellipse", "means"
EFFECTS: dict[str, Kind] = {
    "thermal_softening": Kind("thermal", (_R, _A, _E, _M), ("theta",)),
    "thermal_damping": Kind("thermal", (_R,), ("theta",)),
    "thermal_viscosity": Kind("thermal", (_R, _A, _E), ("theta",)),
    "proxy_lag": Kind("thermal", (_R, _A), ("theta", "softened")),
    "flow_stress_softening": Kind("thermal", (_E, _M), ("theta",)),
    "direction_asymmetry": Kind("direction", (_R, _A, _E, _M)),
    "viscous_friction": Kind("speed", (_R, _A, _E, _M)),
    "stribeck": Kind("speed", (_R, _A, _E), ("flat",)),
    "load_dependence": Kind("load", (_R, _E, _M), ("load",)),
    "size_effect": Kind("load", (_E, _M)),
    "edge_force": Kind("load", (_E, _M)),
    "minimum_chip_thickness": Kind("load", (_E, _M)),
    "sticking_limit": Kind("load", (_E, _M)),
    "process_damping": Kind("load", (_E, _M)),
    "elasto_plastic": Kind("presliding", (_R, _A), ("lugre",)),
    "maxwell_slip": Kind("presliding", (_R, _A), ("lugre",)),
    "dwell_strengthening": Kind("state", (_R,), ("rests",)),
    "rate_and_state": Kind("state", (_R, _A)),
    "friction_wear": Kind("wear", (_R, _A)),
    "position_dependence": Kind("position", (_R, _A)),
    "backlash": Kind("lag", (_A,)),
    "input_delay": Kind("lag", (_R, _A)),
    "sensor_delay": Kind("lag", (_R, _A, _E)),
    "sensor_lowpass": Kind("lag", (_R, _A, _E)),
    "dynamometer_resonance": Kind("lag", (_R, _E)),
    "sensor_gain": Kind("gain", (_E, _M)),
    "cross_talk": Kind("gain", (_E, _M)),
    "sensor_offset": Kind("zero", (_R, _A, _E, _M)),
    "sensor_drift": Kind("zero", (_R, _A)),
    "line_disturbance": Kind("line", (_R, _A)),
    "ellipse_phase_error": Kind("path", (_E, _M)),
    "amplitude_loss": Kind("path", (_E, _M)),
}
# Effects of the library that no case has, for the families of what a diagnosis may name.
FAMILY = {name: kind.family for name, kind in EFFECTS.items()} | {
    "flank_wear": "wear", "holder_compliance": "lag", "run_out": "path", "regenerative": "path",
}  # fmt: skip

# name: (split, what of the library says the same as this base law). LuGre, the right form, is in both.
BASE_LAWS: dict[str, tuple[str, frozenset[str]]] = {
    "lugre_variant": ("development", frozenset()),
    "generalised_maxwell_slip": ("development", frozenset({"maxwell_slip"})),
    "lagged_coulomb": ("development", frozenset()),
    "lugre_presliding": ("kept", frozenset()),
    "leuven": ("kept", frozenset({"maxwell_slip"})),
    "rate_and_state": ("kept", frozenset({"rate_and_state", "dwell_strengthening"})),
}
BASE_CUTS: dict[str, tuple[str, frozenset[str]]] = {
    "ploughing": ("development", frozenset({"edge_force", "minimum_chip_thickness"})),
    "shear_zone": ("kept", frozenset({"size_effect", "flow_stress_softening"})),
    "smooth_entry": ("kept", frozenset()),
}


def laws(split: str) -> list[str]:
    """Friction laws of other form than LuGre's that a split has."""
    return [name for name, (own, _) in BASE_LAWS.items() if own == split]


def cuts(split: str) -> list[str]:
    return [name for name, (own, _) in BASE_CUTS.items() if own == split]


def unknowns(split: str, world: str) -> list[str]:
    return [name for name, (worlds, kept, _) in KINDS.items() if kept == (split == "kept") and world in worlds]


def forms(split: str, effect: str) -> dict[str, Maker]:
    """Those at even places are for development, those at odd places are kept."""
    return {how: make for place, (how, make) in enumerate(FORMS[effect].items()) if place % 2 == (split == "kept")}


def effects(world: str) -> list[str]:
    return [name for name, kind in EFFECTS.items() if world in kind.worlds]


def stands_for(law: str, cut: str) -> frozenset[str]:
    """Effects of the library whose naming is a true statement on this base law."""
    return BASE_LAWS.get(law, ("", frozenset()))[1] | BASE_CUTS.get(cut, ("", frozenset()))[1]
