"""`evat experiment init`: how does a folder of data files become an experiment? Asks in a terminal, takes all as options without one."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from evat.commands.shared import Json, Values, grouped, print_json, typed_values
from evat.commands.tables import WholeTable
from evat.console import err, marked, out
from evat.files.writing import OutputError, usable
from evat.model import EvatError, ParameterError
from evat.units import number_and_unit, to_si

if TYPE_CHECKING:
    from evat.experiment import Experiment
    from evat.experiment.begin.understood import Answers, Begun, Question
    from evat.experiment.read import Scan

PICTURE = "experiment.png"
MOST_SAMPLES = 1_000_000  # of a recording, in the picture: beyond that it would not fit into memory everywhere


@dataclass(frozen=True)
class SignalOptions:
    """What was recorded, where the headers do not say."""

    signal: Annotated[
        list[str] | None, typer.Option("--signal", help="NAME=COLUMN: which column a variable is, such as slip_velocity='CH 2'; repeat it.")
    ] = None
    unit: Annotated[list[str] | None, typer.Option("--unit", "-u", help="COLUMN=UNIT where the header does not say; repeat it.")] = None
    radius: Annotated[str | None, typer.Option(help="Lever arm of an angle or a torque, such as '20 mm'; of a screw its lead/2/pi.")] = None
    motor_constant: Annotated[
        str | None,
        typer.Option(
            help="Force or torque that a column in A or V stands for, such as '52 N/A', '0.5 N.m/A' or '10 N/V'; of a friction "
            "coefficient the load, such as '50 N'."
        ),
    ] = None


@dataclass(frozen=True)
class RigOptions:
    """What is believed of the rig beside the recordings."""

    mass: Annotated[str | None, typer.Option(help="What a drive accelerates, such as '30 kg'.")] = None
    title: Annotated[str, typer.Option(help="Heads every report.")] = ""
    parameters: Annotated[str, typer.Option("--set", "-s", help="The nominal model: a shipped set, or an .ssv file in the folder.")] = ""
    friction: Annotated[str, typer.Option(help="The nominal friction law.")] = ""
    value: Values = None


@dataclass(frozen=True)
class FormOptions:
    """How the files are written: [reader] of experiment.toml."""

    delimiter: Annotated[str | None, typer.Option(help="What stands between the columns; \\t is a tab.")] = None
    decimal: Annotated[str | None, typer.Option(help="Decimal mark, . or ,")] = None
    encoding: Annotated[str | None, typer.Option(help="Of the headers, such as cp1252.")] = None
    skip_rows: Annotated[int | None, typer.Option(help="Lines above the line of headers.", min=0)] = None
    columns: Annotated[
        str | None, typer.Option(help="Headers of files that have none, in their order, such as 't [s], v [m/s], F [N]'.")
    ] = None


@grouped
def init(
    *,
    folder: Annotated[Path, typer.Argument(help="A folder with recordings or averages: CSV, text or Parquet.")],
    signals: SignalOptions,
    nominal: RigOptions,
    form: FormOptions,
    force: Annotated[bool, typer.Option("--force", help="Replace an experiment.toml that is there.")] = False,
    as_json: Json = False,
) -> None:
    """Look at a folder of data files and write an experiment.toml with every guess marked, and a picture and a page of what was understood.

    Example: evat experiment init measurements --radius '20 mm' --motor-constant '0.5 N.m/A'
    """
    from evat.experiment.begin.files import NoHeaders
    from evat.experiment.begin.guess import begin
    from evat.experiment.begin.write import Believed, check_free, to_look_at, write_begun

    check_free(folder, force=force)
    answers = _answers(signals)
    _known_form(answers, form)
    law, mass = nominal.friction, None if nominal.mass is None else to_si(nominal.mass, "kg", name="mass")
    values = typed_values(nominal.value, {"friction_law": f"--friction {law}"} if law else {})
    believed = Believed(nominal.title, nominal.parameters, law, values, mass)
    try:
        begun, questions = begin(folder, answers)
    except NoHeaders as error:
        if not sys.stdin.isatty():
            raise
        _ask_headers(answers, str(error))
        begun, questions = begin(folder, answers)
    while begun is None:
        if not sys.stdin.isatty():
            raise ParameterError(_missing(folder, questions))
        for question in questions:
            _ask(question, answers)
        begun, questions = begin(folder, answers)
    written, sentences = write_begun(begun, believed, force=force), to_look_at(begun, believed)
    if as_json:
        print_json(_document(begun, written, sentences))
    out.print(_table(begun))
    for reason in begun.left:
        err.print(f"not used: {reason}")
    out.print(f"wrote {written}")
    _understood(folder, sentences)
    for sentence in sentences:
        out.print(marked("look:", "bold yellow", sentence), soft_wrap=True)
    out.print(f"next: look at {written} and the page, then: evat experiment check {folder}", soft_wrap=True)


def _answers(signals: SignalOptions) -> Answers:
    from evat.experiment.begin.understood import Answers

    answers = Answers()
    for text in signals.signal or ():
        _told_signal(answers, *_pair("--signal", text))
    for text in signals.unit or ():
        _told_unit(answers, *reversed(_pair("--unit", text, last=True)))
    if signals.radius is not None:
        _told_radius(answers, signals.radius)
    if signals.motor_constant is not None:
        _told_constant(answers, signals.motor_constant)
    return answers


def _known_form(answers: Answers, form: FormOptions) -> None:
    """What is told of how the files are written; checked as the document's own [reader] is, where it is read."""
    from evat.files.text import TextForm, known_encoding

    told: dict[str, Any] = {name: entry for name, entry in vars(form).items() if entry is not None}
    if form.delimiter:
        told["delimiter"] = form.delimiter.replace("\\t", "\t")
    if form.columns is not None:
        told["columns"] = _headers(form.columns)
    if not known_encoding(told.get("encoding", "utf-8")):
        raise ParameterError(f"--encoding {told['encoding']!r}: no such encoding of text; write it like utf-8 or cp1252.")
    if len(told.get("delimiter", ";")) != 1:
        raise ParameterError(f"--delimiter {told['delimiter']!r}: one character is needed.")
    if told.get("decimal", ".") not in (".", ","):
        raise ParameterError(f"--decimal {told['decimal']!r}: allowed are . and ,")
    answers.form, answers.stated = TextForm(**told), tuple(told)


def _headers(text: str) -> tuple[str, ...]:
    headers = tuple(header.strip() for header in text.split(","))
    if len(named := [header for header in headers if header]) < 2 or len(set(named)) < len(named):
        raise ParameterError(f"--columns {text!r}: two headers or more are needed, each once, with commas between them.")
    return headers


def _pair(option: str, text: str, *, last: bool = False) -> tuple[str, str]:
    name, equals, entry = text.rpartition("=") if last else text.partition("=")
    if not equals or not name.strip() or not entry.strip():
        raise ParameterError(f"{option} {text!r}: write {'COLUMN=UNIT' if last else 'NAME=COLUMN'}.")
    return name.strip(), entry.strip()


def _told_signal(answers: Answers, name: str, column: str) -> None:
    from evat.experiment.document import BESIDE
    from evat.native import kernel

    if name not in BESIDE and kernel.variable(name).type != "real":
        raise ParameterError(f"--signal {name}: only numbers are recorded.")
    answers.signals[name] = column


def _told_unit(answers: Answers, unit: str, column: str) -> None:
    from evat.files.spelling import unit_meant
    from evat.units import base_unit

    known = unit_meant(unit) or unit
    base_unit(known)
    answers.units[column] = known


def _told_radius(answers: Answers, text: str) -> None:
    answers.radius = to_si(text, "m", name="radius")
    if not answers.radius > 0:
        raise ParameterError(f"radius = {text!r}: a length above 0 is needed.")


def _told_constant(answers: Answers, text: str) -> None:
    told = number_and_unit(text)
    if told is None:
        raise ParameterError(f"motor constant = {text!r}: a number and a unit are needed, such as '0.5 N.m/A'.")
    answers.motor_constant = (float(told[0]), told[1])


def _missing(folder: Path, questions: Sequence[Question]) -> str:
    """What to say where nobody can be asked: each question, and the options that would answer them all."""
    asked = []
    for question in questions:
        among = f" ({', '.join(map(repr, question.choices[:12]))})" if question.choices else ""
        asked.append(f"{question.asked}{among} Say {question.option}.")
    return f"{folder}: {' '.join(asked)} (In a terminal these are asked.)"


def _ask_headers(answers: Answers, why: str) -> None:
    """Of files that have none."""
    err.print(why, highlight=False, soft_wrap=True)
    while True:
        try:
            headers = _headers(str(typer.prompt("what are the columns, in their order, such as t [s], v [mm/s], F [N]", err=True)))
        except ParameterError as error:
            err.print(marked("no:", "bold red", str(error)), soft_wrap=True)
            continue
        answers.form, answers.stated = replace(answers.form, columns=headers), (*answers.stated, "columns")
        return


def _ask(question: Question, answers: Answers) -> None:
    """Until there is an answer that can be used."""
    while True:
        for number, choice in enumerate(question.choices, 1):
            err.print(f"  {number}: {choice}", highlight=False)
        told = str(typer.prompt(question.asked, err=True)).strip()
        if question.choices and told.isdigit() and 1 <= int(told) <= len(question.choices):
            told = question.choices[int(told) - 1]
        try:
            if question.choices and told not in question.choices:
                raise ParameterError(f"{told!r}: answer with a number or a name of the list.")
            if question.option.startswith("--signal"):
                _told_signal(answers, question.key, told)
            elif question.option.startswith("--unit"):
                _told_unit(answers, told, question.key)
            elif question.key == "radius":
                _told_radius(answers, told)
            else:
                _told_constant(answers, told)
            return
        except EvatError as error:
            err.print(marked("no:", "bold red", str(error)), soft_wrap=True)


def _document(begun: Begun, written: Path, look: Sequence[str]) -> dict[str, Any]:
    """What was understood, for programs."""
    return {
        "experiment": str(written),
        "signals": {signal.name: {**signal.table, "goes_by": signal.why or "you said so"} for signal in begun.signals},
        "trials": [{"file": trial.file, "condition": trial.condition} for trial in begun.trials],
        "not_used": list(begun.left),
        "look": list(look),
    }


def _table(begun: Begun) -> WholeTable:
    count = len(begun.recorded.files)
    table = WholeTable(
        "variable", "column", "unit", "what it goes by", title=f"{count} file{'s' if count > 1 else ''}", title_justify="left"
    )
    for signal in begun.signals:
        more = [f"{key} {signal.table[key]}" for key in ("from", "sign", "radius", "scale") if key in signal.table]
        table.add_row(signal.name, str(signal.table["column"]), ", ".join([str(signal.table["unit"]), *more]), signal.why or "you said so")
    conditions: dict[str, int] = {}
    for trial in begun.trials:
        conditions[trial.condition] = conditions.get(trial.condition, 0) + 1
    if conditions:
        table.caption = "conditions: " + ", ".join(f"{name} ({count})" for name, count in conditions.items())
    return table


def _understood(folder: Path, look: Sequence[str]) -> None:
    """As a picture and a page, read back as every other command will read it; or what is wrong with it."""
    from evat.experiment import ExperimentError
    from evat.experiment.read import read_experiment, scan_experiment
    from evat.experiment.skips import skipped
    from evat.models.contact import ContactModel
    from evat.plots.experiment import plot_experiment
    from evat.plots.experiment_page import PAGE

    try:
        experiment = read_experiment(folder, ContactModel(), most=MOST_SAMPLES)
        scan = scan_experiment(folder, ContactModel())
        if experiment.trials:
            out.print(f"wrote {plot_experiment(experiment, folder / PICTURE, left_out(scan))}")
        lost = (*skipped(scan), *(remark.text for remark in scan.remarks))
        out.print(f"wrote {write_page(scan, folder / PAGE, (*look, *lost), experiment)}")
        for doubt in lost:
            err.print(marked("warning:", "bold yellow", doubt), soft_wrap=True)
    except ExperimentError as error:
        err.print(marked("not yet fit:", "bold red", str(error)), soft_wrap=True)


def check_page(to: Path | None) -> None:
    """OutputError where `to` is given and is no page, or cannot be written: asked before data are read."""
    if to is None:
        return
    if to.suffix.lower() not in (".html", ".htm"):
        raise OutputError(f"--out {to}: a page is written; name it .html.")
    if to.is_dir():
        raise OutputError(f"--out {to}: this is a folder; name a file in it, such as {to / 'experiment.html'}.")
    usable(to.parent)


def write_page(scan: Scan, to: Path, look: Sequence[str], experiment: Experiment | None = None) -> Path:
    """The page of an experiment, which is read again where it is not given."""
    from evat.experiment.read import read_experiment
    from evat.files.writing import put
    from evat.models.contact import ContactModel
    from evat.plots.experiment_page import page

    if experiment is None and scan.trials:
        experiment = read_experiment(scan.document.files[0], ContactModel(), most=MOST_SAMPLES)
    return put(to, page(scan, to, experiment if scan.trials else None, look, left_out(scan)), "the page")


def left_out(scan: Scan) -> str:
    """What a picture does not show of long recordings; "" where it shows them whole."""
    longer = [trial for trial in scan.trials if trial.rows > MOST_SAMPLES]
    if not longer:
        return ""
    return f"the first {MOST_SAMPLES} samples of each recording; {longer[0].file} has {longer[0].rows}"
