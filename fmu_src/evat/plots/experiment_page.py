"""What does an experiment hold, in tables and as a page? Channels, recordings, averages, nominal model, and the reports on these data."""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from evat import html as pages
from evat.experiment import Experiment, SetupSd, Signal, as_typed
from evat.experiment.document import POSITION, Document
from evat.experiment.means import named_after
from evat.experiment.read import Scan, day_of
from evat.headline import Headline
from evat.native import kernel
from evat.plots.cycles import inline
from evat.plots.experiment import drawn
from evat.units import affine, display

PAGE = "experiment.html"  # in the folder of an experiment
LARGE_ZERO = 0.2  # of the root mean square of its channel: a zero that may be off by more is hardly meant
EVEN = 1.01  # longest over shortest step up to which a clock is called even
REPORTS = {"diagnosis.json": "diagnosis", "identification.json": "identification"}  # what lies beside a report.html, and what that is of


@dataclass(frozen=True, slots=True)
class PrintedTable:
    """Rows of texts under their heads."""

    title: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def shown(value: float, name: str, signals: Mapping[str, Signal] | None = None) -> str:
    """A value of a variable in the unit of the owner's files, where these have it."""
    return display(value, as_typed(kernel.variable(name), signals or {}), digits=4)


def _recorded(value: float, signal: Signal, signals: Mapping[str, Signal]) -> str:
    """A number of what was recorded; of a velocity that is taken from a position, a number of that."""
    if signal.of != POSITION:
        return shown(value, signal.name, signals)
    length = signal.unit if signal.radius is None and signal.scale is None else "mm"
    return display(value, replace(kernel.variable(signal.name), unit="m", display_unit=length), digits=4)


def _rms(value: float, signal: Signal, signals: Mapping[str, Signal]) -> str:
    """Root mean square of what was recorded: from the zero of SI, so in SI where the column counts from another, as degC does."""
    known = as_typed(kernel.variable(signal.name), signals)
    if affine(known.unit, known.display_unit or known.unit)[1] != 0:
        return display(value, replace(known, display_unit=known.unit), digits=4)
    return _recorded(value, signal, signals)


def _label(signal: Signal) -> str:
    return f"{signal.name} (its position)" if signal.of == POSITION else signal.name


def channels_of(scan: Scan) -> PrintedTable:
    """What was recorded: role, column, unit, and the least and most of all recordings."""
    signals, rows = scan.document.signals, []
    for signal in (each for each in scan.document.recorded if each.role is not None):
        least, most = min(trial.least[signal.name] for trial in scan.trials), max(trial.most[signal.name] for trial in scan.trials)
        ends = (_recorded(least, signal, signals), _recorded(most, signal, signals))
        rows.append((_label(signal), signal.role or "", signal.column, signal.unit, *ends))
    return PrintedTable("What was recorded", ("signal", "role", "column", "unit in the file", "least", "most"), tuple(rows))


def trials_of(scan: Scan) -> PrintedTable:
    """Each recording: condition, rows, clock, and the root mean squares."""
    signals, rows = scan.document.signals, []
    recorded = [signal for signal in scan.document.recorded if signal.role is not None]
    for trial in scan.trials:
        rate = f"{(trial.rows - 1) / (trial.end - trial.begin):.6g}"
        if trial.longest > EVEN * trial.shortest:
            rate += f" (steps {trial.shortest:.3g} to {trial.longest:.3g} s)"
        facts = (trial.file, trial.condition, str(trial.rows), f"{trial.begin:g}, {trial.end:g}", rate)
        rows.append((*facts, *(_rms(trial.rms[signal.name], signal, signals) for signal in recorded)))
    heads = ("file", "condition", "rows", "from, to [s]", "rate [Hz]", *(f"rms {_label(signal).replace('_', ' ')}" for signal in recorded))
    return PrintedTable(scan.document.title, heads, tuple(rows))


def means_of(scan: Scan) -> PrintedTable | None:
    """The averages, a row for each condition; its name where that is not what varied, which stands in the columns beside it."""
    means = scan.means
    if means is None:
        return None
    columns = {**means.values, **means.outputs}
    own = [named_after({name: float(column[row]) for name, column in means.values.items()}) for row in range(len(means.conditions))]
    named = not means.values or tuple(own) != means.conditions
    rows = tuple(
        (*((condition,) if named else ()), *(shown(float(column[row]), name, scan.document.signals) for name, column in columns.items()))
        for row, condition in enumerate(means.conditions)
    )
    heads = (*(("condition",) if named else ()), *(name.replace("_", " ") for name in columns))
    return PrintedTable(f"averages: {means.file}", heads, rows)


def conditions_told(scan: Scan) -> str:
    """How many conditions there are, and how often each was measured."""
    averaged = scan.means.conditions if scan.means is not None else ()
    measured = Counter([*(trial.condition for trial in scan.trials), *averaged])
    told = f"{len(measured)} condition{'s' if len(measured) != 1 else ''}"
    repeats = [count for count in measured.values() if count > 1]
    if not repeats:
        return f"{told}, none of them repeated"
    often = str(repeats[0]) if len(set(repeats)) == 1 else f"{min(repeats)} to {max(repeats)}"
    whose = f"{len(repeats)} of them measured" if len(repeats) < len(measured) else "each measured" if len(repeats) > 1 else "measured"
    return f"{told}, {whose} {often} times"


def _known_to(share: float) -> str:
    percent = 100 * share
    return f"to {percent:.0f} %" if percent >= 100 else f"to {percent:.3g} %" if share else "exactly"


def values_known(document: Document) -> str:
    """How well the owner knows the nominal values: those of each relative standard deviation, the least known first."""
    nominal, shares = document.nominal, dict[float, list[str]]()
    for name, value in nominal.values.items():
        known = kernel.variable(name)
        if not isinstance(value, str) and known.type == "real":
            stays = value == 0 or known.variability != "tunable" or known.reference
            share = 0.0 if stays else nominal.known_to(known)
            shares.setdefault(share, []).append(name)
    told = [f"{_known_to(share)}: {', '.join(shares[share])}" for share in sorted(shares, reverse=True)]
    return f"values are known (standard deviation) {'; '.join(told)}" if told else ""


def setup_known(scan: Scan) -> str:
    """How far each measured channel may be off in all that was measured alike."""
    document = scan.document
    measured = [signal.name for signal in document.recorded if signal.role == "output"] if scan.trials else []
    measured += [] if scan.means is None else list(scan.means.outputs)

    def told(sd: SetupSd, name: str) -> str:
        zero = f"{100 * SetupSd.ZERO_OF_RMS:.3g} % of the rms" if sd.zero is None else shown(sd.zero, name, document.signals)
        clock = "" if name.startswith("mean_") else f", clock {'one sample' if sd.clock is None else f'{sd.clock:.3g} s'}"
        return f"gain {100 * sd.gain:.3g} %, zero {zero}{clock}"

    alike: dict[str, list[str]] = {}
    for name in measured:
        alike.setdefault(told(document.setup_sd.get(name, SetupSd()), name), []).append(name)
    return "set-up is known (standard deviation) " + "; ".join(f"of {', '.join(names)} to: {each}" for each, names in alike.items())


def large_zeros(scan: Scan) -> tuple[str, ...]:
    """Zeros that are stated to be off by much of what their channel shows, a sentence each: many are typed in another unit."""
    told, signals = [], scan.document.signals
    for name, sd in scan.document.setup_sd.items():
        largest = max((trial.rms.get(name, 0.0) for trial in scan.trials), default=0.0)
        if sd.zero is not None and largest > 0 and sd.zero > LARGE_ZERO * largest:
            own, rms, unit = shown(sd.zero, name, signals), shown(largest, name, signals), signals[name].unit
            told.append(
                f"setup_sd.{name}.zero lets its zero be off by {own}, where its root mean square is {rms} at most. It is in the unit of "
                f"the column, {unit}: is that meant?"
            )
    return tuple(told)


def page(scan: Scan, to: Path, recordings: Experiment | None, doubts: Sequence[str], left_out: str = "") -> str:
    """The page of an experiment that is to lie at `to`. recordings : to be drawn; doubts : what deserves a look; left_out : what the
    picture does not show."""
    nominal, averages, signals = scan.document.nominal, means_of(scan), scan.document.signals
    tables = [channels_of(scan), replace(trials_of(scan), title="Recordings")] if scan.trials else []
    tables += [] if averages is None else [replace(averages, title="Averages")]
    values = {name: value if isinstance(value, str) else shown(value, name, signals) for name, value in nominal.values.items()}
    return pages.render(
        "experiment.html.j2",
        document=scan.document,
        headline=_headline(scan, doubts),
        day=day_of(scan.document),
        tables=tables,
        picture=None if recordings is None else inline(drawn(recordings, left_out=left_out)),
        narrow=None if recordings is None else inline(drawn(recordings, narrow=True, left_out=left_out)),
        values=[(kernel.variable(name), value) for name, value in values.items()],
        known=[sentence for sentence in (values_known(scan.document), setup_known(scan)) if sentence],
        files={_link(path, to): "read with it" if place else "the experiment" for place, path in enumerate(scan.document.files)},
        reports=reports_beside(to, scan.data_hash),
        data_hash=scan.data_hash,
    )


def reports_beside(to: Path, data_hash: str) -> dict[str, str]:
    """Reports on the same data in the folders that lie in that of the page `to`, or beside it: links, and what each is."""
    folder = Path(os.path.abspath(to)).parent
    reports = {}
    for name, what in REPORTS.items():
        for document in sorted({*folder.glob(f"*/{name}"), *folder.parent.glob(f"*/{name}")}):
            with suppress(OSError, ValueError, AttributeError):
                made_by = json.loads(document.read_text(encoding="utf-8")).get("made_by", {})
                if made_by.get("data") == data_hash and document.with_name("report.html").is_file():
                    reports[_link(document.with_name("report.html"), to)] = what
    return reports


def pages_on(experiment: Experiment, report: Path, kind: str) -> dict[str, str]:
    """Other pages on the same data, as links from `report` and what each is: that of the experiment, where it has one, and reports of
    another `kind` that lie beside this one."""
    place = experiment.folder / PAGE
    measured = {_link(place, report): "what was measured"} if experiment.folder != Path() and place.is_file() else {}
    beside = reports_beside(report, experiment.data_hash)
    return measured | {link: f"{what} of the same data" for link, what in beside.items() if what != kind}


def _link(path: Path, to: Path) -> str:
    return Path(os.path.relpath(path, Path(os.path.abspath(to)).parent)).as_posix()


def _headline(scan: Scan, doubts: Sequence[str]) -> Headline:
    recordings = len(scan.trials)
    parts = [f"{recordings} recordings"] if recordings else []
    parts += [f"{len(scan.means.conditions)} rows of averages"] if scan.means is not None else []
    sentence = f"{' and '.join(parts)} of {conditions_told(scan)}."
    name = scan.document.folder.name or "."
    return Headline(
        "can be read" if not doubts else "look",
        "good" if not doubts else "attention",
        sentence[0].upper() + sentence[1:],
        reasons=tuple(doubts),
        next=f"evat diagnose {name} says why measurement and nominal model disagree; evat identify {name} finds parameters.",
    )
