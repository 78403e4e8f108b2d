"""What stands in the guide where a page says `<!-- table: NAME -->`? Tables, asked of what declares it. A hook of mkdocs, by its path."""

from __future__ import annotations

import html
import itertools
import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import evat
from evat import parameter_sets
from evat.constants import CONSTANTS, Constant, Value
from evat.experiment import keys as experiment_keys
from evat.fmu import fmu_facts_of, parts
from evat.gap.verdict import sensitivity
from evat.gap.verdict.constants import in_use
from evat.model import Effect, Law, Variable
from evat.native import kernel
from evat.native.compile import source_root
from evat.units import display

MARK = re.compile(r"^<!-- (table|include): (.+?) -->$", re.MULTILINE)
NOT_MEASURED = "not yet"
NOT_READ = "not read"
OF_SETS = ("names", "load", "load_ssv", "save_ssv")


def on_page_markdown(markdown: str, **_: Any) -> str:
    """mkdocs: a page before it becomes HTML."""
    return MARK.sub(lambda match: TABLES[match[2]]() if match[1] == "table" else _included(match[2]), markdown)


def _included(path: str) -> str:
    """A how-to that lies beside the code that it speaks of."""
    return (source_root() / path).read_text(encoding="utf-8")


def _text(text: str) -> str:
    """As Markdown, inside a table too."""
    return re.sub(r"([*_])(?=\S)", r"\\\1", html.escape(text, quote=False)).replace("|", "&#124;")


def _code(text: str, kind: str = "name") -> str:
    """A name, in one piece, or an equation; inside a table too."""
    escaped = html.escape(text, quote=False)
    for mark, entity in (("|", "&#124;"), ("*", "&#42;"), ("_", "&#95;")):
        escaped = escaped.replace(mark, entity)
    return f'<code class="{kind}">{escaped}</code>' if text else ""


def _table(headers: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    headers = tuple(headers)
    lines = [headers, ("---",) * len(headers), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _number(value: float, variable: Variable) -> str:
    return "" if math.isnan(value) else _text(display(value, variable, digits=4))


def _allowed(variable: Variable) -> str:
    if variable.choices:
        return ", ".join(f"{_code(name)} ({number})" for name, number in variable.items.items())
    if variable.type == "boolean":
        return "true, false"
    unit = "" if variable.unit == "1" else f" {variable.unit}"
    return f"{variable.min:g} to {variable.max:g}{_text(unit)}"


def _variables(rows: Iterable[Variable]) -> str:
    return _table(
        ("name", "start", "allowed", "meaning", "source"),
        ((_code(each.name), _number(each.start, each), _allowed(each), _text(each.meaning), _text(each.source)) for each in rows),
    )


def _outputs(rows: Iterable[Variable]) -> str:
    return _table(("name", "unit", "meaning"), ((_code(each.name), _text(each.unit), _text(each.meaning)) for each in rows))


def _of_the_contact(causality: str) -> list[Variable]:
    """Variables of the contact itself: neither of a law nor of an effect alone."""
    entries: tuple[Law | Effect, ...] = (*kernel.laws(), *kernel.effects())
    owned = {variable.name for entry in entries for variable in entry.variables}
    owned |= {effect.name for effect in kernel.effects()}
    return [variable for variable in kernel.variables() if variable.causality == causality and variable.name not in owned]


def _laws() -> str:
    def row(law: Law) -> tuple[str, ...]:
        own = ", ".join(_code(variable.name) for variable in law.variables)
        return (_code(law.name), _text(law.meaning), _code(law.equation, "equation"), own, _text(law.source))

    return _table(("law", "what it is", "equation", "parameters of its own", "source"), map(row, kernel.laws()))


def _what(effect: Effect) -> str:
    return effect.physics


def _effects() -> str:
    rows = ((_text(e.stage), f"[{_code(e.name)}](#{e.name})", _text(_what(e)), ", ".join(map(_code, e.needs))) for e in kernel.effects())
    return _table(("stage", "effect", "what it is", "needs the input"), rows)


def _own(variables: Iterable[Variable]) -> str:
    """The parameters of an effect."""
    rows = ((_code(v.name), _number(v.start, v), _allowed(v), _number(v.neutral, v), _text(f"{v.meaning} [{v.source}]")) for v in variables)
    return _table(("parameter", "start", "allowed", "neutral", "meaning [source]"), rows)


def _effects_in_full() -> str:
    lines: list[str] = []
    for stage, group in itertools.groupby(kernel.effects(), key=lambda effect: effect.stage):
        lines.append(f"## Stage: {stage}\n")
        for effect in group:
            facts = [f"{_text(_what(effect)[:1].upper() + _what(effect)[1:])}.", ""]
            facts += [f"- **Equation:** {_code(effect.equation, 'equation')}", f"- **In a record:** {_text(effect.signature)}"]
            facts += [f"- **Source:** {_text(effect.source)}", f"- **Family:** {_text(effect.family)}"]
            facts += [f"- **Rivals:** {', '.join(map(_code, effect.rivals))}"] if effect.rivals else []
            facts += [f"- **Special cases:** {', '.join(map(_code, effect.special_cases))}"] if effect.special_cases else []
            facts += [f"- **Applies to:** {', '.join(map(_code, effect.applies_to))}"] if effect.applies_to else []
            facts += [
                "- **Unsteady:** it goes by the time or the way itself, so that means of steady states tell nothing of it."
            ] * effect.unsteady
            facts += ["- **Irreversible:** what it has changed stays so from recording to recording."] * effect.irreversible
            facts += ["- **Keeps means:** it is a filter or a delay, of which means tell nothing."] * effect.keeps_mean
            facts += [
                "- **Form of law:** friction laws differ in it among themselves, so that a little of it is no effect."
            ] * effect.form_of_law
            table = _own(effect.variables) if effect.variables else ""
            lines.append(f"### {_text(effect.name)} {{#{effect.name}}}\n\n" + "\n".join(facts) + f"\n\n{table}")
    return "\n".join(lines)


def _sets() -> str:
    shipped = map(parameter_sets.load, parameter_sets.names())
    rows = ((_code(each.name), _text(each.title), ", ".join(map(_code, each.effects))) for each in shipped)
    return _table(("set", "what it is", "effects on"), rows)


def _parts() -> str:
    rows = ((_code(fmu_facts_of(part).model_name), _text(fmu_facts_of(part).description), _code(part)) for part in parts())
    return _table(("FMU", "what it is", "part, for `evat.build_fmu`"), rows)


def _names(prefix: str, names: Iterable[str]) -> str:
    return "\n".join(f"::: {prefix}.{name}\n" for name in names)


def _value(value: Value | list[float]) -> str:
    return ", ".join(f"{each:.4g}" for each in (value if isinstance(value, (tuple, list)) else (value,)))


def _change(row: Mapping[str, Any] | None) -> str:
    """What one replaced value did to the stored cases."""
    if row is None:
        return NOT_MEASURED
    failed = f", {row['failed']} fail" if row["failed"] else ""
    return f"{row['log_loss']:+.3f} ({row['right']:+d}, {row['changed']}{failed})"


def _origin_of_constants() -> str:
    """How the judgement is founded, in one sentence."""
    declared = CONSTANTS.declared().values()
    count = {origin: sum(each.origin == origin for each in declared) for origin in ("guess", "calibrated", "derived")}
    bare = sum(each.origin == "guess" and not each.source for each in declared)
    return (
        f"Of {len(declared)} numbers {count['guess']} are guesses, {bare} of which give no reason; {count['calibrated']} are calibrated to "
        f"simulated cases and {count['derived']} derived.\n"
    )


def _constants() -> str:
    rows, values = sensitivity.read().get("constants", {}), in_use()

    def row(name: str, each: Constant[Value]) -> tuple[str, ...]:
        # A figure that was made with another value says nothing of this one.
        measured = rows.get(name, {})
        measured = measured if _value(values[name]) == _value(measured.get("value", math.nan)) else {}
        origin = f"{each.origin}: {each.source}" if each.source else each.origin
        unread = measured.get("read_in") == 0
        changes = (NOT_READ if unread else _change(measured.get(word)) for word in ("halved", "doubled"))
        cases = str(measured.get("read_in", 0))
        return (_code(name), _value(values[name]), _text(each.unit), _text(each.meaning), _text(origin), cases, *changes)

    headers = ("constant", "value", "unit", "meaning", "origin", "read in", "half", "twice")
    lines = [row(name, each) for name, each in CONSTANTS.declared().items()]
    missing = sum(NOT_MEASURED in line for line in lines)
    unread = sum(NOT_READ in line for line in lines)
    told = (
        f"Measured: {len(lines) - missing} of {len(lines)} constants, {unread} of which no case that was run reads; {missing} not yet.\n\n"
    )
    return told + _table(headers, lines)


def _keys() -> str:
    """Every table of an experiment.toml."""
    lines: list[str] = []
    for head, keys in experiment_keys.TABLES.items():
        rows = ((_code(key.name) + " (needed)" * key.needed, _text(key.takes), _text(key.default), _text(key.meaning)) for key in keys)
        title = f"`{head}`" if head else "At the top"
        lines.append(f"### {title}\n\n{_table(('key', 'takes', 'where it is missing', 'meaning'), rows)}")
    return "\n".join(lines)


TABLES: dict[str, Callable[[], str]] = {
    "laws": _laws,
    "effects": _effects,
    "effects in full": _effects_in_full,
    "inputs": lambda: _variables(_of_the_contact("input")),
    "parameters": lambda: _variables(_of_the_contact("parameter")),
    "outputs": lambda: _outputs(_of_the_contact("output")),
    "sets": _sets,
    "constants": _constants,
    "origin of constants": _origin_of_constants,
    "keys": _keys,
    "parts": _parts,
    "names": lambda: _names("evat", sorted((name for name in evat.__all__ if name != "parameter_sets"), key=str.lower)),
    "names of parameter_sets": lambda: _names("evat.parameter_sets", OF_SETS),
}
