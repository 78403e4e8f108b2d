"""How does an experiment get from its folder into memory, and how large may it be? Nothing is resampled or filled.

Files are read in batches: checking a record takes hardly any memory, holding it no more than its own numbers.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from os import PathLike
from pathlib import Path

import numpy as np

from evat.experiment import DISTANCE, Experiment, Means, Remark, Trial
from evat.experiment.column import Column
from evat.experiment.columns import trial_batches, trial_columns
from evat.experiment.derived import derived, noise_of_positions
from evat.experiment.document import TRIGGER, Document, TrialEntry, read_document
from evat.experiment.means import read_means
from evat.experiment.trigger import triggered
from evat.files.text import TextForm
from evat.model import FloatArray, Model

__all__ = ["Scan", "TrialFacts", "read_experiment", "scan_experiment"]

HASHED = 1 << 20  # bytes at a time
GROWTH = 1.125  # of a column whose length its file does not tell

Progress = Callable[[float], None]


@dataclass(slots=True)
class TrialFacts:
    """What a recording holds, without its samples: first and last time and the shortest, longest and usual step [s], after which samples
    the first two come, and for each signal the least, the most and the root mean square (SI). The usual step is the median of those read
    first."""

    file: str
    condition: str
    rows: int = 0
    begin: float = math.nan
    end: float = math.nan
    shortest: float = math.inf
    longest: float = 0.0
    usual: float = math.nan
    longest_after: int = 0
    shortest_after: int = 0
    longest_from: float = math.nan
    least: dict[str, float] = field(default_factory=dict)
    most: dict[str, float] = field(default_factory=dict)
    rms: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Scan:
    """What an experiment holds, without its samples; `data_hash` is the one it has when it is read."""

    document: Document
    trials: tuple[TrialFacts, ...]
    means: Means | None
    data_hash: str
    remarks: tuple[Remark, ...] = ()


def read_experiment(
    folder_or_toml: str | PathLike[str], model: Model | None = None, *, progress: Progress | None = None, most: int | None = None
) -> Experiment:
    """Read a measured experiment, in SI and checked throughout.

    Parameters
    ----------
    folder_or_toml : path
        Its folder, or the experiment.toml in it.
    model : Model, optional
        What the measurements are of; its variables are what signals may be called. Without it a `ContactModel`.
    progress : callable, optional
        Told the share that is done.
    most : int, optional
        Samples of a trial to keep, its first; without it all. Those beyond are checked, too.

    Returns
    -------
    Experiment
        Trials and means with the nominal model; nothing is resampled or filled.

    Raises
    ------
    ExperimentError
        Names the file and the key, column or row, what is allowed, and what to do.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, repeats=2, speeds=[0.5], rate=100.0)
    >>> folder = evat.write_experiment(made, "rig")
    >>> experiment = evat.read_experiment(folder)
    >>> experiment.conditions, experiment.outputs, experiment.nominal.values["friction_law"]
    (('speed 1',), ('friction_force',), 'coulomb')
    """
    if model is None:
        from evat.models.contact import ContactModel

        model = ContactModel()
    document = read_document(Path(folder_or_toml), model)
    done = ShareDone(document, progress)
    data_hash = hash_of(document, done)
    remarks = list[Remark]()
    trials = tuple(
        trial
        for entry in document.trials
        for trial in read_entry(entry, trial_columns(document, entry, model), document, model, done, most, remarks)
    )
    return assembled(document, trials, model, data_hash, remarks)


def assembled(document: Document, trials: tuple[Trial, ...], model: Model, data_hash: str, remarks: Sequence[Remark] = ()) -> Experiment:
    """An experiment of these trials, its averages read."""
    means = None if document.means is None else read_means(document, *document.means, model)
    return Experiment(
        document.folder,
        document.title,
        document.intended_use,
        document.nominal,
        document.signals,
        trials,
        means,
        data_hash,
        document.setup_sd,
        day_of(document),
        tuple(remarks),
        0.0 if document.inertia is None else document.inertia.mass,
    )


def scan_experiment(folder_or_toml: Path, model: Model, *, progress: Progress | None = None) -> Scan:
    """The same checks as read_experiment, keeping no samples: for records of any size."""
    document = read_document(Path(folder_or_toml), model)
    done = ShareDone(document, progress)
    data_hash = hash_of(document, done)
    remarks = list[Remark]()
    trials = tuple(_scan_trial(entry, trial_columns(document, entry, model), done, document.form, remarks) for entry in document.trials)
    means = None if document.means is None else read_means(document, *document.means, model)
    return Scan(document, trials, means, data_hash, tuple(remarks))


class ShareDone:
    """Turns bytes into the share that is done: every file is gone through for its hash, recordings `passes` more times."""

    def __init__(self, document: Document, progress: Progress | None, passes: int = 1) -> None:
        recorded = sum(entry.path.stat().st_size for entry in document.trials)
        self._total = sum(path.stat().st_size for path in document.files) + passes * recorded
        self._bytes, self._progress = 0, progress

    def __call__(self, more: int) -> None:
        self._bytes += more
        if self._progress is not None:
            self._progress(min(1.0, self._bytes / self._total))


def day_of(document: Document) -> str:
    """When the newest of its files was last changed, a day of UTC: a report of them has no other date, lest it change by itself."""
    return datetime.fromtimestamp(max(path.stat().st_mtime for path in document.files), timezone.utc).date().isoformat()


def hash_of(document: Document, done: Callable[[int], None]) -> str:
    """sha256 over the bytes of all files, each with its length in front."""
    digest = hashlib.sha256()
    for path in document.files:
        digest.update(path.stat().st_size.to_bytes(8, "little"))
        with path.open("rb") as file:
            while block := file.read(HASHED):
                digest.update(block)
                done(len(block))
    return digest.hexdigest()


def read_entry(
    entry: TrialEntry,
    columns: list[Column],
    document: Document,
    model: Model,
    done: Callable[[int], None],
    most: int | None,
    remarks: list[Remark],
) -> list[Trial]:
    """The recording, or where a trigger marks several parts of it, one for each; what should be known of it goes to the remarks."""
    trigger = next((place for place, column in enumerate(columns) if column.name == TRIGGER), None)
    if trigger is None:
        return [_read_trial(entry, columns, document, done, most, remarks)]
    whole = _read_trial(entry, columns, document, done, None, remarks)
    wears = any(effect.irreversible for effect in model.effects if effect.name in document.nominal.effects)
    trials = triggered(whole, columns[trigger].header, wears and any(variable.name == DISTANCE for variable in model.variables))
    return trials if most is None else [trial.head(most) for trial in trials]


def _read_trial(
    entry: TrialEntry,
    columns: list[Column],
    document: Document,
    done: Callable[[int], None],
    most: int | None,
    remarks: list[Remark],
) -> Trial:
    held = [np.empty(0) for _ in columns]
    at = 0

    def room(rows: int) -> None:  # in place: no second copy
        for column in held:
            column.resize(rows if most is None else min(rows, most), refcheck=False)

    for batch in trial_batches(entry, columns, done, room, document.form, remarks):
        end = at + batch[0].size if most is None else min(at + batch[0].size, most)
        if end > held[0].size:
            room(max(end, int(GROWTH * held[0].size)))
        for column, values in zip(held, batch, strict=True):
            column[at:end] = values[: end - at]
        at = end
    room(at)
    position_sd = noise_of_positions(columns, held, document)
    held = derived(entry.file, columns, held, document)
    for column in held:
        column.flags.writeable = False
    by_role: dict[str | None, dict[str, FloatArray]] = {None: {}, "input": {}, "output": {}}
    for known, column in zip(columns, held, strict=True):
        by_role[document.signals[known.name].role][known.name] = column
    marked = {TRIGGER: by_role[None][TRIGGER]} if TRIGGER in by_role[None] else {}
    outputs = {**by_role["output"], **marked}
    return Trial(entry.file, entry.condition, entry.values, held[0], by_role["input"], outputs, None, entry.noise_sd, position_sd)


def _scan_trial(entry: TrialEntry, columns: list[Column], done: Callable[[int], None], form: TextForm, remarks: list[Remark]) -> TrialFacts:
    facts, squares = TrialFacts(entry.file, entry.condition), np.zeros(len(columns))
    for batch in trial_batches(entry, columns, done, lambda rows: None, form, remarks):
        times, end = batch[0], facts.end
        steps = np.diff(times, prepend=end) if facts.rows else np.diff(times)
        facts.begin, facts.end = (facts.begin if facts.rows else float(times[0])), float(times[-1])
        if steps.size and math.isnan(facts.usual):
            facts.usual = float(np.median(steps))
        before = facts.rows if facts.rows else 1  # what the first of these steps comes after
        if steps.size and steps.min() < facts.shortest:
            facts.shortest_after = before + int(np.argmin(steps))
        if steps.size and steps.max() > facts.longest:
            place = int(np.argmax(steps))
            facts.longest_after = before + place
            facts.longest_from = float(times[place] if not facts.rows else (end if place == 0 else times[place - 1]))
        facts.rows += times.size
        if steps.size:
            facts.shortest, facts.longest = min(facts.shortest, float(steps.min())), max(facts.longest, float(steps.max()))
        for known, column in zip(columns, batch, strict=True):
            facts.least[known.name] = min(facts.least.get(known.name, math.inf), float(column.min()))
            facts.most[known.name] = max(facts.most.get(known.name, -math.inf), float(column.max()))
        squares += [float(np.square(column).sum()) for column in batch]
    facts.rms = {known.name: math.sqrt(total / facts.rows) for known, total in zip(columns[1:], squares[1:], strict=True)}
    return facts
