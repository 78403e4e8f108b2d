"""What does the owner of an experiment believe of the model today? The table [nominal] of its document."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from evat import parameter_sets
from evat.constants import CONSTANTS
from evat.experiment import InitialBristle, Nominal
from evat.experiment.checks import MOST, Checks, is_size, near, shown
from evat.experiment.keys import keys
from evat.model import EvatError
from evat.required_inputs import SOURCE

CHOICES = {"friction": "friction_law", "kinematics": "kinematics"}  # key of [nominal] -> the component's variable
INITIAL_BRISTLE = "initial_bristle"
RELATIVE_SD, SD = "relative_sd", "sd"  # tables of how well values are known
INERTIA = ("mass", "gravity_load")  # of what moves; keys of [nominal] that are no variables of the component
KEYS = keys("[nominal]")  # the document takes mass and gravity_load out before


def read_nominal(checks: Checks, table: Mapping[str, Any]) -> tuple[Nominal, list[Path]]:
    choices = {key: name for key, name in CHOICES.items() if name in checks.variables}
    checks.keys("nominal", table, [key for key in KEYS if key not in CHOICES or key in choices], ())
    values: dict[str, float | str] = {}
    effects: tuple[str, ...] = ()
    files: list[Path] = []
    name = checks.text("nominal.parameters", table.get("parameters", ""))
    if name:
        where = "nominal.parameters"
        if name not in parameter_sets.names():
            files = [checks.inside(where, name)]
        try:
            known = parameter_sets.load(files[0] if files else name)
        except EvatError as error:
            raise checks.error(where, str(error)) from error
        values = {key: checks.value(where, key, number, by_place=True) for key, number in known.values.items()}
        effects = known.effects
    elif not table.get("values"):
        raise checks.error(
            "nominal", "there are no values; name a shipped set or an .ssv file as parameters, or list them in [nominal.values]."
        )
    for key, number in checks.numbers("nominal.values", table.get("values", {})):
        if key in choices.values():
            raise checks.error(
                f"nominal.values.{key}", f"the choice stands in [nominal] as {next(k for k, v in choices.items() if v == key)}."
            )
        if key in KEYS and key not in checks.variables:
            raise checks.error(f"nominal.values.{key}", f"it is no value of the component; {key} stands in [nominal] itself, one level up.")
        values[key] = checks.value(f"nominal.values.{key}", key, number)
    for key, variable in choices.items():
        if key in table:
            values[variable] = checks.value(f"nominal.{key}", variable, table[key])
        elif variable not in values:
            raise checks.error("nominal", f"{key} is missing; allowed are {', '.join(checks.variables[variable].choices)}.")
    if SOURCE in table:
        values[SOURCE] = checks.value(f"nominal.{SOURCE}", SOURCE, table[SOURCE])
    if "effects" in table:
        effects = _effects(checks, table["effects"])
    relative_sd = {
        key: _known_to(checks, RELATIVE_SD, key, number)
        for key, number in checks.numbers(f"nominal.{RELATIVE_SD}", table.get(RELATIVE_SD, {}))
    }
    for key, number in checks.numbers(f"nominal.{SD}", table.get(SD, {})):
        relative_sd[key] = _share(checks, key, _known_to(checks, SD, key, number), values.get(key, 0.0), relative_sd)
    begins = table.get(INITIAL_BRISTLE, "free")
    if begins not in get_args(InitialBristle):
        raise checks.error(f"nominal.{INITIAL_BRISTLE}", f"{shown(begins)}; allowed are {', '.join(get_args(InitialBristle))}.")
    return Nominal(values, effects, relative_sd, parameters=name, initial_bristle=begins), files


def _effects(checks: Checks, names: Any) -> tuple[str, ...]:
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise checks.error("nominal.effects", f'{shown(names)}; a list of names is needed, such as ["{checks.effects[0]}"], or [].')
    for name in names:
        if name not in checks.effects:
            raise checks.error("nominal.effects", f"there is no effect {shown(name)}; {near(name, checks.effects)}")
        if names.count(name) > 1:
            raise checks.error("nominal.effects", f"{name!r} is there twice; keep one.")
    return tuple(names)


def _known_to(checks: Checks, table: str, key: str, entry: Any) -> float:
    """A number of one of the two tables that say how well values are known."""
    where = f"nominal.{table}.{key}"
    if key in INERTIA:
        known = f"a mass is known to {100 * CONSTANTS.mass_sd:.3g} %, and put right with the set-up of the force; so is its zero"
        raise checks.error(where, f"{key} has no standard deviation of its own: {known}; remove it.")
    variable = checks.settable(where, key)
    if variable.type != "real":
        raise checks.error(where, "only numbers are known more or less well; remove it.")
    if not is_size(entry, 0):
        example = "0.1 for 10 %" if table == RELATIVE_SD else f"0.1 for 0.1 {variable.unit}"
        raise checks.error(
            where, f"{shown(entry)}; a number of at least 0 and at most {MOST:g} is needed, such as {example}; 0 means exact."
        )
    return float(entry)


def _share(checks: Checks, key: str, sd: float, value: float | str, stated: Mapping[str, float]) -> float:
    """A standard deviation in the unit of its value as a share of it."""
    where = f"nominal.{SD}.{key}"
    if key in stated:
        raise checks.error(where, f"it stands in nominal.{RELATIVE_SD}, too; keep one.")
    if not value:
        raise checks.error(where, f"{key} is not stated, or 0, which stays as it is; state its value in nominal.values.")
    return sd / abs(float(value))
