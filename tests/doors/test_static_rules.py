"""Do the descriptions keep what the standard asks for in words? The rules of VDMCheck, its model of FMI 2 and that of FMI 3 read side by
side, for all that our FMUs have: no clocks, no arrays, no aliases.

Causality with variability, initial and start; values within their bounds and types; what types and units say of each other; derivatives;
the ModelStructure's lists, their order, and what an unknown may depend on; the head. FMI 2.0.4, sections 2.2.1 to 2.2.9, 3.3.1 and 4.3.1;
FMI 3.0.1, sections 2.4.1 to 2.4.8. What fmpy's own validation holds as well is in test_description.py, terminals in test_terminals.py.
"""

from __future__ import annotations

import math
import re
import zipfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import pytest
from evat import fmu
from evat.native import kernel
from fmpy import read_model_description
from fmpy.model_description import ModelDescription, ScalarVariable, Unknown
from lxml import etree

REALS = ("Real", "Float64")
KINDS = {"dependent", "constant", "fixed", "tunable", "discrete"}
STANDARD = {"logEvents", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal", "logAll"}
Rule = Callable[[ModelDescription], Iterator[str]]


def number(text: object, otherwise: float) -> float:
    return otherwise if text is None else float(str(text))


def names(description: ModelDescription) -> Iterator[str]:
    """Structured: letters, digits and points, no blank at either end; a type is not called as a variable or another type is."""
    variables = {v.name for v in description.modelVariables}
    types = [each.name for each in description.typeDefinitions]
    yield from (f"{name}: no structured name" for name in variables if not re.fullmatch(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", name))
    yield from (f"{name}: a type called like another or a variable" for name in types if types.count(name) > 1 or name in variables)


RUNNING = ("discrete", "continuous")
ALLOWED = {  # by causality: the variabilities and what may be said of the start; the first is meant where nothing is said
    "parameter": (("fixed", "tunable"), ("exact",)),
    "structuralParameter": (("fixed", "tunable"), ("exact",)),
    "calculatedParameter": (("fixed", "tunable"), ("calculated", "approx")),
    "input": (RUNNING, ("exact", None)),  # the word is fmpy's: test_what_is_given_says_nothing_of_its_start
    "independent": (("continuous",), ("exact", None)),
    "output": (RUNNING, ("calculated", "exact", "approx")),
    "local": (RUNNING, ("calculated", "exact", "approx")),
}


def roles(description: ModelDescription) -> Iterator[str]:
    """Causality, variability, initial and start fit each other; what is continuous is real; one variable at most is independent; one
    reference each, and one at most is settable more than once in an instant."""
    if len([v for v in description.modelVariables if v.causality == "independent"]) > 1:
        yield "two independent variables"
    references = [v.valueReference for v in description.modelVariables]
    if len(set(references)) < len(references):
        yield "a value reference twice"
    for v in description.modelVariables:
        usual = "continuous" if v.type in REALS else "discrete"
        causality, variability = v.causality or "local", v.variability or usual
        variabilities, initials = ALLOWED[causality]
        initial = v.initial or initials[0]
        needs_start = causality == "input" or (causality != "independent" and initial in ("exact", "approx"))
        if variability not in variabilities or initial not in initials or (v.start is not None) != needs_start:
            yield f"{v.name}: {causality}, {variability}, {initial}, start {v.start}"
        if variability == "continuous" and v.type not in REALS:
            yield f"{v.name}: a continuous {v.type}"
        if v.canHandleMultipleSetPerTimeInstant is False and not (causality == "input" and description.modelExchange):
            yield f"{v.name}: set once in an instant"


def values(description: ModelDescription) -> Iterator[str]:
    """min <= start <= max, 0 < nominal, all finite; a start is one of the items."""
    for v in description.modelVariables:
        if v.type == "Boolean":
            if v.start not in (None, "true", "false"):
                yield f"{v.name}: start {v.start} of a Boolean"
            continue
        if v.type == "Enumeration":
            items = [int(item.value) for item in v.declaredType.items]
            if len(set(items)) < len(items) or (v.start is not None and int(v.start) not in items):
                yield f"{v.name}: start {v.start} is none of {items}, or these are not unique"
            continue
        low, high, start, nominal = number(v.min, -math.inf), number(v.max, math.inf), number(v.start, math.nan), number(v.nominal, 1)
        if not low <= high or start < low or start > high or (v.start is not None and not math.isfinite(start)):
            yield f"{v.name}: {low} <= {start} <= {high}"
        if not 0 < nominal < math.inf:
            yield f"{v.name}: nominal {nominal}"


def types(description: ModelDescription) -> Iterator[str]:
    """A declared type is of the variable's kind and unit, and holds its bounds; units are there once, with the display units that are
    used; items have names and values of their own."""
    units = {unit.name: {shown.name for shown in unit.displayUnits or ()} for unit in description.unitDefinitions}
    if len(units) < len(description.unitDefinitions):
        yield "a unit twice"
    for each in (*description.typeDefinitions, *description.modelVariables):
        if (each.unit or "") not in {"", *units} or (each.displayUnit and each.displayUnit not in units.get(each.unit, ())):
            yield f"{each.name}: unit {each.unit}, shown in {each.displayUnit}"
    for each in description.typeDefinitions:
        if len({item.name for item in each.items or ()}) < len(each.items or ()):
            yield f"{each.name}: an item twice"
    for v in description.modelVariables:
        declared = v.declaredType
        if declared is None:
            continue
        kind = declared.type.removesuffix("Type")
        if kind != v.type or (declared.unit, declared.displayUnit or v.displayUnit) != (v.unit, v.displayUnit):
            yield f"{v.name}: of type {declared.name} ({kind}, {declared.unit}), but {v.type}, {v.unit}"
        if v.type in REALS and (
            number(v.min, math.inf) < number(declared.min, -math.inf) or number(v.max, -math.inf) > number(declared.max, math.inf)
        ):
            yield f"{v.name}: beyond the bounds of {declared.name}"


def exponents(description: ModelDescription, unit: str) -> tuple[dict[str, int], float]:
    definition = next(each for each in description.unitDefinitions if each.name == unit)
    base = definition.baseUnit
    return {name: int(getattr(base, name) or 0) for name in ("kg", "m", "s", "A", "K", "mol", "cd", "rad")}, float(base.factor or 1)


def derivatives(description: ModelDescription) -> Iterator[str]:
    """A derivative is a real, continuous variable, no parameter and no input, of another such one, in its unit per second."""
    for v in description.modelVariables:
        if (state := v.derivative) is None:
            continue
        if state is v or any(each.type not in REALS or each.variability != "continuous" for each in (v, state)):
            yield f"{v.name}: derivative of {state.name}"
            continue
        if v.causality not in ("local", "output") or state.causality not in ("local", "output"):
            yield f"{v.name}: {v.causality}, of {state.name}: {state.causality}"
        (own, factor), (its, other) = (exponents(description, each.unit) for each in (v, state))
        if own != {**its, "s": its["s"] - 1} or factor != other:
            yield f"{v.name} [{v.unit}] is no rate of {state.name} [{state.unit}]"


def order(description: ModelDescription) -> Iterator[str]:
    """Lists have each unknown once, in the order of the table; derivatives are those of one list of states."""
    place = {v.name: n for n, v in enumerate(description.modelVariables)}
    lists = {"outputs": description.outputs, "initial unknowns": description.initialUnknowns}
    for kind, unknowns in lists.items():
        places = [place[u.variable.name] for u in unknowns]
        if places != sorted(set(places)):
            yield f"{kind}: not in order, or one twice"
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    if [u.variable.name for u in description.outputs] != outputs:
        yield "outputs: not those of the variables"
    known = {v for u in description.initialUnknowns for v in u.dependencies or ()}
    for u in description.initialUnknowns:
        asked = u.variable.causality in ("output", "calculatedParameter") or u.variable.derivative or u.variable in description.derivatives
        if (
            not asked
            or u.variable.initial == "exact"
            or u.variable in known
            or u.variable in {e.variable for e in description.eventIndicators}
        ):
            yield f"initial unknowns: {u.variable.name} is none"
    if {u.variable.name for u in description.derivatives} != {v.name for v in description.modelVariables if v.derivative}:
        yield "derivatives: not those of the variables"
    states = [u.variable.derivative.name for u in description.derivatives if u.variable.derivative]
    if len(set(states)) != len(description.derivatives):
        yield "derivatives: one is none, or two are of one state"


def _is_known(v: ScalarVariable, states: set[str], *, at_start: bool) -> bool:
    running = v.causality in ("input", "independent") or v.name in states
    return running or (at_start and v.causality in ("parameter", "structuralParameter") and v.initial == "exact")


def dependencies(description: ModelDescription) -> Iterator[str]:
    """Each known once, in order; it is an input, the time, a state, or at the start a parameter. A kind for each, other than the general
    one for reals alone."""
    place = {v.name: n for n, v in enumerate(description.modelVariables)}
    states = {u.variable.derivative.name for u in description.derivatives if u.variable.derivative}
    running: Sequence[Unknown] = (*description.outputs, *description.derivatives, *description.eventIndicators)
    for at_start, unknowns in ((False, running), (True, description.initialUnknowns)):
        for u in unknowns:
            places = [place[known.name] for known in u.dependencies or ()]
            kinds = u.dependenciesKind or []
            if places != sorted(set(places)) or len(kinds) not in (0, len(places)):
                yield f"{u.variable.name}: {places}, {kinds}"
            if wrong := [known.name for known in u.dependencies or () if not _is_known(known, states, at_start=at_start)]:
                yield f"{u.variable.name} depends on {wrong}, which are not known"
            allowed = {"dependent", "constant"} if at_start else KINDS if u.variable.type in REALS else {"dependent"}
            if set(kinds) - allowed:
                yield f"{u.variable.name}: {sorted(set(kinds))}, allowed are {sorted(allowed)}"


def head(description: ModelDescription) -> Iterator[str]:
    """There is an interface, identifiers are those of C, categories of the log the standard's, the date is one of UTC, the experiment goes
    forward."""
    if not description.coSimulation and not description.modelExchange:
        yield "no interface"
    if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", description.generationDateAndTime or ""):
        yield f"date {description.generationDateAndTime}"
    for interface in (description.coSimulation, description.modelExchange):
        if interface is not None and not re.fullmatch(r"[A-Za-z_]\w*", interface.modelIdentifier):
            yield f"modelIdentifier {interface.modelIdentifier}"
    categories = [category.name for category in description.logCategories]
    if len(set(categories)) < len(categories) or not STANDARD.issuperset(categories):
        yield f"categories {categories}"
    experiment = description.defaultExperiment
    start, stop, step = number(experiment.startTime, 0), number(experiment.stopTime, 1), number(experiment.stepSize, 1e-9)
    if not 0 <= start < stop or not 0 < step <= stop - start or not number(experiment.tolerance, 1) > 0:
        yield f"experiment {start} to {stop} by {step}"


RULES: tuple[Rule, ...] = (names, roles, values, types, derivatives, order, dependencies, head)


def complaints(description: ModelDescription) -> list[str]:
    return [f"{rule.__name__}: {line}" for rule in RULES for line in rule(description)]


FILES = ["python", *(f"{part}-fmi{version}" if at else f"fmi{version}" for at, part in enumerate(fmu.parts()) for version in (2, 3))]


@pytest.mark.parametrize("name", FILES)
def test_the_description_keeps_the_rules_in_words(name: str, fmus: dict[str, Path]) -> None:
    assert complaints(read_model_description(str(fmus[name]), validate=False)) == []


@pytest.mark.parametrize("name", FILES)
def test_what_is_given_says_nothing_of_its_start(name: str, fmus: dict[str, Path]) -> None:
    """fmpy puts a word of its own where there is none."""
    with zipfile.ZipFile(fmus[name]) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    assert root.xpath("//*[@causality='input' or @causality='independent']")
    assert not root.xpath("//*[@causality='input' or @causality='independent'][@initial]")


@pytest.mark.parametrize("version", [2, 3])
def test_an_event_sets_states_alone(version: int, fmus: dict[str, Path]) -> None:
    """What is set there fmpy does not read."""
    with zipfile.ZipFile(fmus[f"fmi{version}"]) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    told = root.xpath("//*[@reinit='true']")
    names = {(element if version == 3 else element.getparent()).get("name") for element in told}
    assert {"bristle_deflection"} <= names <= set(kernel.states())


BROKEN = {  # in the description of the cut: what is put in the place of what, and the rule that says so
    "a name with a blank": (3, 'name="feed"', 'name="feed "', "names"),
    "a variable called as a type": (3, 'name="feed"', 'name="Force"', "names"),
    "a parameter that is an output's kind": (3, r'(name="feed"[^>]*variability=")tunable', r"\g<1>continuous", "roles"),
    "an input without a start": (2, r'(name="cutting_speed".*?<Real[^>]*) start="[^"]*"', r"\1", "roles"),
    "a result with a start": (3, r'(name="principal_force"[^>]*)/>', r'\1 start="1"/>', "roles"),
    "a continuous whole number": (2, r'(name="in_contact"[^>]*variability=")discrete', r"\g<1>continuous", "roles"),
    "a reference twice": (2, r'(name="feed" valueReference=")\d+', r"\g<1>{width}", "roles"),
    "a unit that is none": (3, r'(name="width"[^>]* unit=")m', r"\g<1>ell", "types"),
    "a display unit of another unit": (2, r'(<Real [^>]*displayUnit=")mm', r"\1deg", "types"),
    "a unit twice": (2, r'(<Unit name="N">.*?</Unit>)', r"\1\1", "types"),
    "an item twice": (3, r'(<Item name=")lugre', r"\1coulomb", "types"),
    "a derivative left out": (2, r"<Derivatives>\s*<Unknown [^>]*>", "<Derivatives>", "order"),
    "an initial unknown that is given": (3, r'(<InitialUnknown valueReference=")\d+', r"\g<1>{feed}", "order"),
    "a date of another zone": (3, r'(generationDateAndTime="[^"]*)Z', r"\1+01:00", "head"),
    "a start above its maximum": (3, r'(name="width"[^>]*start=")[^"]*', r"\g<1>7", "values"),
    "a start that is no item": (2, r'(name="friction_law".*?start=")2', rf"\g<1>{len(kernel.laws()) + 1}", "values"),
    "a nominal of 0": (3, r'(name="width"[^>]*nominal=")[^"]*', r"\g<1>0", "values"),
    "a type in another unit": (3, r'(Float64Type name="Force"[^>]* unit=")N', r"\g<1>Pa", "types"),
    "a rate of another quantity": (2, r'(name="contact_rate".*?derivative=")\d+', r"\g<1>{recent_feed_impulse}", "derivatives"),
    "a rate of a parameter": (3, r'(name="bristle_rate"[^>]*derivative=")\d+', r"\g<1>{feed}", "derivatives"),
    "two rates of one state": (3, r'(name="contact_rate"[^>]*derivative=")\d+', r"\g<1>{bristle_deflection}", "order"),
    "outputs out of order": (3, r"(<Output [^>]*>)(\s*)(<Output [^>]*>)", r"\3\2\1", "order"),
    "an initial unknown twice": (2, r"(<InitialUnknowns>\s*)(<Unknown [^>]*>)", r"\1\2\2", "order"),
    "knowns out of order": (2, r'(<Outputs>\s*<Unknown [^>]*dependencies=")(\d+) (\d+)', r"\1\3 \2", "dependencies"),
    "a parameter that an output follows": (3, r'(<Output [^>]*dependencies=")\d+ \d+', r"\g<1>{feed} {friction_force}", "dependencies"),
    "a kind too few": (3, r'(<Output [^>]*dependenciesKind=")\w+ ', r"\1", "dependencies"),
    "a kind that is none": (3, r'(<Output [^>]*dependenciesKind=")\w+ ', r"\1linear ", "dependencies"),
    "an identifier with a dash": (3, 'modelIdentifier="EvatCut"', 'modelIdentifier="Evat-Cut"', "head"),
    "a category of our own": (2, '"logEvents"', '"events"', "head"),
    "an experiment that goes back": (3, r'(<DefaultExperiment[^>]*stopTime=")[^"]*', r"\g<1>-1", "head"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_breaks_a_rule_is_told(case: str, fmus: dict[str, Path], tmp_path: Path) -> None:
    version, pattern, put, rule = BROKEN[case]
    with zipfile.ZipFile(fmus[f"evat_cut-fmi{version}"]) as archive:
        text = archive.read("modelDescription.xml").decode()
    references = dict(re.findall(r'name="(\w+)" valueReference="(\d+)"', text))
    for name, reference in references.items():
        put = put.replace(f"{{{name}}}", reference)
    broken, count = re.subn(pattern, put, text, count=1, flags=re.DOTALL)
    assert count == 1
    (tmp_path / "modelDescription.xml").write_text(broken, encoding="utf-8")
    told = complaints(read_model_description(str(tmp_path), validate=False))
    assert any(line.startswith(f"{rule}: ") for line in told), told
