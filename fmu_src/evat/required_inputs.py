"""Is every input there without which an effect that is on, or the friction law, says nothing? The one place that reads Effect.needs; knows
no effect and no law by name."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from evat.model import Law, ParameterError, Tables, Variable

MOTION, KINEMATICS = "slip_velocity", "kinematics"  # what every friction law answers to, and the choice of where it comes from
FRICTION = "friction_force"  # what it answers
LAW = "friction_law"
AMPLITUDES = ("amplitude_x", "amplitude_y")  # of the vibration; conventional turning has none
# An effect that needs the temperature proxy needs what the proxy is taken from, by the name of that choice.
PROXY, SOURCE = "proxy_speed", "proxy_source"
PROXY_INPUT = {"slip_speed": MOTION}


def missing_inputs(
    model: Tables, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str] = ()
) -> dict[str, list[str]]:
    """Inputs that effects need and a run does not have: input -> the effects that need it.

    on : effects that are on; those switched on in `values` count too.
    values : parameters and constant inputs of the run; what stands there is given.
    given : names of the inputs that the run has a column for.
    """
    by_name = {variable.name: variable for variable in model.variables}

    def choice(name: str) -> str:
        variable = by_name[name]
        return variable.choices[int(variable.check(values.get(name, variable.start)))]

    missing: dict[str, list[str]] = {}
    for effect in model.effects:
        if effect.name not in on and not values.get(effect.name):
            continue
        for need in effect.needs:
            source = choice(SOURCE) if need == PROXY else need
            name = PROXY_INPUT.get(source, source)
            with_all = not by_name[name].required_with
            if (with_all or choice(KINEMATICS) in by_name[name].required_with) and name not in values and name not in given:
                missing.setdefault(name, []).append(effect.name)
    return missing


def unread_inputs(
    model: Tables, values: Mapping[str, float | str], recorded: Collection[str], stated: Collection[str] = ()
) -> tuple[str, ...]:
    """Inputs that could be the temperature proxy, which `values` take from something else: a sentence each, with what to set.

    recorded : names of the inputs with a column of their own.
    stated : names of those that trials or averages state a value of. One that tells a motion, too (the cutting speed of a test), is a
        remark on the test, and no doubt.
    """
    by_name = {variable.name: variable for variable in model.variables}
    if (source := by_name.get(SOURCE)) is None:
        return ()
    chosen = source.choices[int(source.check(values.get(SOURCE, source.start)))]
    return tuple(
        f"{name} is {'recorded' if name in recorded else 'stated'} and the model does not read it: its temperature proxy is taken from "
        f"{chosen}. "
        f'Set {SOURCE} = "{name}" in [nominal] to use it, or leave it out.'
        for name in source.choices
        if name in recorded or (name in stated and name in by_name and not by_name[name].required_with)
        if name not in (chosen, MOTION) and name in by_name and by_name[name].causality == "input"
        if not by_name[name].required_with or values.get(KINEMATICS) in by_name[name].required_with  # elsewhere the motion reads it
    )


def unused_by_law(
    model: Tables, laws: Sequence[Law], values: Mapping[str, float | str], on: Collection[str], recorded: Collection[str]
) -> tuple[str, ...]:
    """Inputs that other friction laws or effects take their force from, and neither the chosen law nor an effect that is on does: a
    sentence each. recorded : names of the inputs with a column of their own."""
    by_name = {variable.name: variable for variable in model.variables}
    choices = by_name[LAW]
    chosen = choices.choices[int(choices.check(values.get(LAW, choices.start)))]
    active = {effect.name for effect in model.effects if effect.name in on or values.get(effect.name)}
    said = []
    for name in sorted(set(recorded) - {MOTION, PROXY}):
        by_laws = [law.name for law in laws if any(read.name == name for read in law.reads)]
        by_effects = [effect.name for effect in model.effects if name in effect.needs]
        if (by_laws or by_effects) and chosen not in by_laws and not active.intersection(by_effects):
            others = [*(f"{LAW} = {law}" for law in by_laws), *(f"the effect {effect}" for effect in by_effects)]
            said.append(
                f"{name} is recorded, and {LAW} = {chosen} does not read it; what reads it: {', '.join(others)}. A diagnosis tries "
                "effects by itself"
            )
    return tuple(said)


def lacks_motion(model: Tables, values: Mapping[str, float | str], given: Collection[str]) -> bool:
    """Whether the kinematics in `values` take the motion from an input that is in neither `values` nor the columns `given`."""
    required = any(variable.name == MOTION and values.get(KINEMATICS) in variable.required_with for variable in model.variables)
    return required and MOTION not in values and MOTION not in given


def check_required_inputs(model: Tables, on: Sequence[str], values: Mapping[str, float | str], given: Collection[str] = ()) -> None:
    """ParameterError where `missing_inputs` finds one."""
    for name, effects in missing_inputs(model, on, values, given).items():
        variable = next(variable for variable in model.variables if variable.name == name)
        several = len(effects) > 1
        proxy = any(PROXY in effect.needs for effect in model.effects if effect.name in effects)
        other = f", or take the temperature proxy from something else ({SOURCE})" if proxy else ""
        raise ParameterError(
            f"the {'effects' if several else 'effect'} {', '.join(effects)} {'need' if several else 'needs'} the input {name} "
            f"({variable.meaning}), and this run has neither a column nor a value of it. Give one in {variable.unit}{other}, "
            f"or switch the {'effects' if several else 'effect'} off."
        )


def inputs_the_law_lacks(
    model: Tables, laws: Sequence[Law], values: Mapping[str, float | str], given: Collection[str] = ()
) -> tuple[str, list[Variable]]:
    """The law that is chosen, and the inputs that it reads, that these kinematics do not compute, and that this run does not have."""
    by_name = {variable.name: variable for variable in model.variables}

    def choice(name: str) -> str:
        variable = by_name[name]
        return variable.choices[int(variable.check(values.get(name, variable.start)))]

    chosen, kinematics = choice(LAW), choice(KINEMATICS)
    law = next(law for law in laws if law.name == chosen)
    return chosen, [
        read
        for read in law.reads
        if read.causality == "input" and kinematics in read.required_with and read.name not in values and read.name not in given
    ]


def check_inputs_of_law(model: Tables, laws: Sequence[Law], values: Mapping[str, float | str], given: Collection[str] = ()) -> None:
    """ParameterError where `inputs_the_law_lacks` finds one."""
    chosen, lacking = inputs_the_law_lacks(model, laws, values, given)
    for read in lacking:
        raise ParameterError(
            f"{LAW} = {chosen} takes its force from the input {read.name} ({read.meaning}), and this run has neither a column nor a value "
            f"of it. Give one in {read.unit}, or choose another law."
        )
