"""How is what was understood written down? As an experiment.toml for people: each guess marked, with what it goes by."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomlkit

from evat.console import printable
from evat.experiment import ExperimentError
from evat.experiment.begin.files import some
from evat.experiment.begin.understood import Begun
from evat.experiment.document import FILE, FORMAT
from evat.experiment.keys import keys, meaning
from evat.files.text import TextForm
from evat.files.writing import put
from evat.native import kernel
from evat.required_inputs import LAW, unused_by_law


@dataclass(frozen=True, slots=True)
class Believed:
    """What its owner says of the model; what is missing is guessed."""

    title: str = ""
    parameters: str = ""
    friction: str = ""
    values: Mapping[str, float | str] = field(default_factory=dict)
    mass: float | None = None


def check_free(folder: Path, *, force: bool) -> None:
    """ExperimentError where there is a document already that must not be replaced."""
    if (folder / FILE).exists() and not force:
        raise ExperimentError(f"{folder / FILE}: there is one already, and it is not overwritten; move it away, or use --force.")


def write_begun(begun: Begun, believed: Believed, *, force: bool) -> Path:
    """Write experiment.toml into the folder of the recordings."""
    folder = begun.recorded.folder
    check_free(folder, force=force)
    return put(folder / FILE, document(begun, believed))


def document(begun: Begun, believed: Believed) -> str:
    """The text of the file."""
    title = believed.title or f"Measurements in {begun.recorded.folder.resolve().name or 'a folder'}"
    lines = [
        "# Written by `evat experiment init`. What is marked `# guessed` was not told: look at each, correct it and remove the mark.",
        f"format = {FORMAT}",
        _line("title", printable(title), "" if believed.title else "from the folder's name"),
        "",
    ]
    lines += _reader(begun) + _nominal(begun, believed)
    for signal in begun.signals:
        lines += [f"[signals.{signal.name}]{_mark(signal.why)}"]
        lines += [_line(key, value) for key, value in signal.table.items()] + [""]
    for reason in begun.left:
        lines.append(f"# not used: {_one_line(reason)}")
    lines += [""] * bool(begun.left)
    if begun.means:
        lines += ["[means]", _line("file", begun.means)]
        lines += [_line("ignore", list(begun.ignored), "no signal goes by them")] if begun.ignored else []
    if begun.trials:
        lines.append(f"# {meaning('[[trials]]', 'condition')}{': ' + begun.repeats if begun.repeats else ''}")
    for trial in begun.trials:
        lines += ["[[trials]]", _line("file", trial.file), _line("condition", trial.condition, begun.repeats or "from the file's name")]
        for key, numbers, why in (
            ("rows", trial.rows, "its clock begins anew there"),
            ("values", trial.values, "SI, from the file's name"),
        ):
            if numbers:
                table = tomlkit.inline_table()
                table.update(numbers)
                lines.append(_line(key, table, why))
        lines.append("")
    return "\n".join(lines).rstrip("\n") + "\n"


def _reader(begun: Begun) -> list[str]:
    form, plain = begun.recorded.sniffed.form, TextForm()
    stated = [(key, getattr(form, key)) for key in keys("[reader]") if getattr(form, key) != getattr(plain, key)]
    if not stated or stated == [("delimiter", ",")]:
        return []
    notes = {"columns": f"guessed: {_one_line(taken_over(begun))}"} if begun.recorded.bare else {}
    return [
        "[reader]  # guessed from the files' first lines",
        *(f"{_line(key, value)}  # {notes.get(key) or meaning('[reader]', key)}" for key, value in stated),
        "",
    ]


def _nominal(begun: Begun, believed: Believed) -> list[str]:
    lines = [f"[nominal]  # {meaning('', 'nominal')}"]
    guessed = not believed.parameters and not believed.values
    told = believed.friction or believed.values.get("friction_law")
    if told or not believed.parameters:
        lines.append(_line("friction", told or "lugre", "" if told else "evat info lists the laws"))
    lines.append(
        _line("kinematics", begun.kinematics, "a motion is recorded" if begun.kinematics == "external" else "no motion is recorded")
    )
    if believed.parameters:
        lines.append(_line("parameters", believed.parameters))
    lines.append(_line("effects", []))
    if believed.mass is not None:
        lines.append(_line("mass", believed.mass))
    elif any("scale" in signal.table or signal.table.get("radius") for signal in begun.signals if signal.table.get("role") == "output"):
        lines.append(f"# mass = 10.0  # {meaning('[nominal]', 'mass')}: state it where a drive accelerates one")
    values = {name: value for name, value in believed.values.items() if name not in ("friction_law", "kinematics")}
    if values:
        lines += ["[nominal.values]", *(_line(name, value) for name, value in values.items())]
    if guessed:
        lines += ["[nominal.values]  # SI", *(_line(name, value, why) for name, (value, _, why) in begun.values.items())]
        lines += [f"[nominal.relative_sd]  # {meaning('[nominal]', 'relative_sd')}"]
        lines += [_line(name, sd, "a first value is not well known") for name, (_, sd, _) in begun.values.items() if sd]
    return [*lines, ""]


def taken_over(begun: Begun) -> str:
    """Whose headers are taken for those of which files."""
    bare = begun.recorded.bare
    return f"the headers of {begun.recorded.headed}, for {some(bare)}, which {'has' if len(bare) == 1 else 'have'} none"


def _line(key: str, value: Any, guessed: str = "") -> str:
    return f"{key} = {tomlkit.item(list(value) if isinstance(value, tuple) else value).as_string()}{_mark(guessed)}"


def _mark(why: str) -> str:
    return f"  # guessed: {_one_line(why)}" if why else ""


def _one_line(text: str) -> str:
    """As a comment: what stands in a header may neither end it nor reach a terminal as a command."""
    return " ".join(printable(text).split())


def to_look_at(begun: Begun, believed: Believed) -> Sequence[str]:
    """What deserves a second look, in sentences."""
    first = (
        () if believed.values or believed.parameters else ("the nominal model is a guess: put in what you believe, or begin with --set",)
    )
    doubt = (f"columns go by {taken_over(begun)}: are they in the same order there?",) if begun.recorded.bare else ()
    values = {**believed.values, **({LAW: believed.friction} if believed.friction else {})}
    inputs = [signal.name for signal in begun.signals if signal.table.get("role") == "input"]
    unused = () if believed.parameters else unused_by_law(kernel.ContactTables(), kernel.laws(), values, (), inputs)
    return (*doubt, *begun.look, *unused, *first)
