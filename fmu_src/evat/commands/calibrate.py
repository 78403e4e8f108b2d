"""`evat calibrate` and `evat benchmark`: how true are the diagnosis's probabilities, and what does it say to a folder of cases?"""

from __future__ import annotations

import importlib.metadata
import json
import os
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import track

from evat.commands.shared import Json, print_json
from evat.commands.tables import WholeTable
from evat.console import err, out
from evat.files.writing import put, usable
from evat.model import EvatError, ParameterError
from evat.processes import process_pool

PROCESSORS = os.cpu_count() or 1
FEWEST = 20  # usable cases, from which constants are kept in the package
Workers = Annotated[int, typer.Option(help="Processes that run at a time; the answer does not depend on it.", min=1)]


def calibrate(
    cases: Annotated[
        int | None,
        typer.Option(
            help="Simulated cases; two cores do about 200 in an hour. With --sensitivity the first so many of its five.",
            min=1,
            show_default="200; with --sensitivity all 5",
        ),
    ] = None,
    state: Annotated[Path, typer.Option(help="Where cases are kept as they are done; a campaign goes on from there.")] = Path(
        "calibration.jsonl"
    ),
    store: Annotated[bool, typer.Option("--store", help="Keep the constants in the package; without it they are only shown.")] = False,
    sensitivity: Annotated[
        bool, typer.Option("--sensitivity", help="Instead: what half and twice each constant of the diagnosis do to five small cases.")
    ] = False,
    constants: Annotated[
        list[str] | None,
        typer.Option(metavar="PATTERN", help="With --sensitivity, only those of such names, as in 'prior_*'; may be given several times."),
    ] = None,
    to: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the constants to this file, too, as the package keeps them.")
    ] = None,
    workers: Workers = PROCESSORS,
    as_json: Json = False,
) -> None:
    """Fit the constants of the diagnosis's judgement to simulated cases whose truth is known.

    Run it again when an effect has been added. Two of three cases are of another form than what is fitted, and every record has what rigs
    have: set-up errors, noisy inputs, repeats out of step. Each case of one effect counts once more as an unknown, with that effect taken
    out of the library. After a change of the diagnosis itself begin with a new --state: cases in it are as the diagnosis was that saw them.

    With --sensitivity, constants are not fitted, but replaced one at a time, which takes half an hour of a core for all of them: a
    diagnosis forks where it first reads a constant (on Windows it begins anew each time). What is done is kept, some constants or cases
    may be asked for at a time, and the guide's page on constants shows what is stored.

    Example: evat calibrate --cases 200 --store

    Example: evat calibrate --sensitivity --constants 'region_*' --cases 3
    """
    if sensitivity:
        return _sensitivity(
            state.with_stem("sensitivity") if state == Path("calibration.jsonl") else state, constants, cases, store, workers, as_json
        )
    if constants:
        raise ParameterError(f"--constants {constants[0]}: it goes with --sensitivity; the calibration fits all its constants at once.")
    if to is not None:
        usable(to.parent)
    cases = 200 if cases is None else cases
    from evat.gap.verdict.calibrate import fit_constants, with_unknown
    from evat.gap.verdict.constants import STORED
    from evat.gap.verdict.constants import store as keep
    from evat.studies.calibration.campaign import campaign, numbers

    done = list(track(campaign(state, cases, workers), description="cases", total=cases, console=err, transient=True))
    if not done or (store and len(done) < FEWEST):
        raise ParameterError(f"{state}: {len(done)} usable cases; at least {FEWEST if store else 1} are needed, ask for more with --cases.")
    fitted, loss = fit_constants(with_unknown(done))
    table = WholeTable("constant", "value")
    for name, value in vars(fitted).items():
        table.add_row(name, f"{value:.4g}")
    if as_json:
        print_json({"constants": vars(fitted), "log_loss": loss, "usable_cases": len(done), "cases": numbers(done)})
    out.print(table)
    out.print(f"mean log loss {loss:.3f} over {len(done)} cases: {numbers(done)}", highlight=False)
    made = {"by": "evat calibrate", "version": importlib.metadata.version("evat"), "cases": numbers(done), "log_loss": round(loss, 4)}
    if to:
        keep(fitted, made, to)
        out.print(f"written to {to}", highlight=False)
    if store:
        keep(fitted, made, STORED)
        out.print("kept in the package")


def _sensitivity(state: Path, patterns: list[str] | None, count: int | None, store: bool, workers: int, as_json: bool) -> None:
    from evat.studies.calibration import constant_sensitivity as study

    names, cases = study.named(patterns or ["*"]), study.CASES[:count]
    held = study.campaign(state, names, workers, cases, tell=lambda done: err.print(f"{done} of {len(cases)} cases", highlight=False))
    table = WholeTable("constant", "value", "half", "twice")
    rows = study.column(held, names, cases)
    if as_json:
        print_json(rows)
    for name, row in rows.items():
        changes = (f"{row[word]['log_loss']:+.3f} ({row[word]['right']:+d}, {row[word]['changed']})" for word in ("halved", "doubled"))
        table.add_row(name, str(row["value"]), *changes)
    out.print(table)
    out.print("change of the mean log loss (of right verdicts, and of how many cases anything changes)", highlight=False)
    if store:
        study.store(held, names, cases)
        out.print("kept in the package")


def benchmark(
    cases: Annotated[Path, typer.Argument(help="Folder of experiment folders.")],
    to: Annotated[Path, typer.Option("--out", "-o", help="Folder for NAME/diagnosis.json of each.")] = Path("benchmark"),
    workers: Workers = PROCESSORS,
    as_json: Json = False,
) -> None:
    """Diagnose every experiment in a folder; tests/gap/blind/score.py compares the answers with sealed labels.

    Answers that are there already are kept, so that a benchmark goes on where it was stopped.
    """
    folders = sorted(path for path in cases.iterdir() if (path / "experiment.toml").is_file()) if cases.is_dir() else []
    if not folders:
        raise ParameterError(f"{cases}: there is no experiment in it; a folder of folders with experiment.toml is needed.")
    usable(to)
    missing = [folder for folder in folders if _verdict(to / folder.name / "diagnosis.json") is None]
    with process_pool(workers) as pool:
        answers = pool.map(_diagnosed, missing)
        for folder, text in track(zip(missing, answers, strict=True), description="cases", total=len(missing), console=err, transient=True):
            put(to / folder.name / "diagnosis.json", text)
    verdicts = {folder.name: str(_verdict(to / folder.name / "diagnosis.json")) for folder in folders}
    if as_json:
        print_json({"verdicts": verdicts, "answers": str(to)})
    counts = sorted(Counter(verdicts.values()).items())
    out.print(", ".join(f"{count} {verdict}" for verdict, count in counts), highlight=False)


def _verdict(path: Path) -> str | None:
    """Of an answer that is there; None where there is none, or it is damaged."""
    try:
        return str(json.loads(path.read_text(encoding="utf-8"))["verdict"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _diagnosed(folder: Path) -> str:
    from evat.experiment.read import read_experiment
    from evat.gap import diagnose
    from evat.models.contact import ContactModel

    began, model = time.monotonic(), ContactModel(1)
    try:
        answer = diagnose(read_experiment(folder, model), model, version=importlib.metadata.version("evat"))
    except EvatError as error:
        return json.dumps({"format": 1, "verdict": "error", "error": str(error)})
    return replace(answer, made_by={**answer.made_by, "seconds": round(time.monotonic() - began, 1)}).json()
