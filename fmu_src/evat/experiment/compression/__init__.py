"""What does a recording tell that is too long to be simulated? Its cycles averaged, what is held averaged, what passes kept: an experiment
as any other, of the whole record.

A stretch that repeats itself becomes a few average cycles, spread over it, each with the cycle before it to lead in, each in two halves
that are repeats of each other (see `pieces`); one that is held becomes averages over its time; transients stay, as finely as the samples
allow. Each knows its time and how far the contact had slid before, so that what changes over the whole record can still be seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path, PurePosixPath

import numpy as np

from evat.constants import CONSTANTS
from evat.experiment import DISTANCE, Experiment, ExperimentError, Remark, SetupSd, Trial
from evat.experiment.column import Column
from evat.experiment.columns import trial_batches, trial_columns, unreadable
from evat.experiment.compression.allotment import pieces_of
from evat.experiment.compression.overview import Overview
from evat.experiment.compression.pieces import Piece
from evat.experiment.compression.stretches import FEWEST_CYCLES, Stretch, stretches
from evat.experiment.compression.summary import CompressionSummary
from evat.experiment.compression.vibration import Demodulation, frequency, steady
from evat.experiment.derived import derived_batches
from evat.experiment.document import TRIGGER, Document, TrialEntry, read_document
from evat.experiment.read import Progress, ShareDone, assembled, hash_of, read_entry, read_experiment
from evat.experiment.skips import skips
from evat.files.stream import rows_about
from evat.files.text import RecordError
from evat.model import FloatArray, Model
from evat.required_inputs import MOTION

__all__ = ["LONG", "Compressed", "compress_experiment", "read_or_compress"]

LONG = 1_000_000  # rows of a trial, from which a record is compressed unasked
PASSES = 2  # over the rows: to see what the record does, and to average
FEWEST_SAMPLES = 500  # that a trial is compressed to


@dataclass(frozen=True)
class Compressed:
    """An experiment whose long trials were compressed, and what was done with each of these."""

    experiment: Experiment
    told: tuple[CompressionSummary, ...]


def read_or_compress(
    folder: Path,
    model: Model,
    *,
    samples: int | None = None,
    whole: bool = False,
    most: int | None = None,
    progress: Progress | None = None,
) -> tuple[Experiment, tuple[str, ...]]:
    """An experiment to be simulated, and what is to be told of it: what was done with its long trials, those of more than LONG rows, which
    are compressed; else what its clocks skip.

    samples : that are kept; see compress_experiment; whole : none is compressed; most : samples of a trial to keep where none is.
    """
    document = read_document(folder, model)
    if whole or not any(_rows_about(entry, document) > LONG for entry in document.trials):
        read = read_experiment(folder, model, progress=progress, most=most)
        return read, skips(read)
    compressed = compress_experiment(folder, model, samples=samples, progress=progress)
    return compressed.experiment, tuple(map(str, compressed.told))


def _rows_about(entry: TrialEntry, document: Document) -> int:
    try:
        beside = sum(other.path == entry.path for other in document.trials)  # recordings of one file: about as long as each other
        return rows_about(entry.path, document.form) // beside
    except RecordError as error:
        raise ExperimentError(unreadable(entry.source, error)) from error


def compress_experiment(
    folder_or_toml: str | PathLike[str], model: Model | None = None, *, samples: int | None = None, progress: Progress | None = None
) -> Compressed:
    """Read an experiment of any length, check every number of it, and compress its long trials to what they tell.

    Parameters
    ----------
    folder_or_toml : path
        Its folder, or the experiment.toml in it.
    model : Model, optional
        What the measurements are of; without it a `ContactModel`.
    samples : int, optional
        That are kept of all trials, repeats counted once; without it as many as a diagnosis simulates. A trial that is not longer than its
        share stays as it is.
    progress : callable, optional
        Told the share that is done.

    Returns
    -------
    Compressed
        `experiment` is one as any other; `told` says what was done.

    Raises
    ------
    ExperimentError
        Names the file and the key, column or row, what is allowed, and what to do.

    Notes
    -----
    Two passes in batches: it takes no more memory for a longer record. The noise of an average is told by its two halves (batch means:
    Law and Carson 1979, not read), that of a transient by its second differences.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, motion="reversal", repeats=1, speeds=[0.5], rate=2000.0)
    >>> compressed = evat.compress_experiment(evat.write_experiment(made, "rig"), samples=600)
    >>> compressed.experiment.samples < made.samples
    True
    """
    if model is None:
        from evat.models.contact import ContactModel

        model = ContactModel()
    samples = CONSTANTS.diagnosed_samples if samples is None else samples
    if samples < FEWEST_SAMPLES:
        raise ExperimentError(f"samples = {samples}: trials are compressed to {FEWEST_SAMPLES} samples at least; ask for more.")
    document = read_document(Path(folder_or_toml), model)
    done = ShareDone(document, progress, PASSES)
    data_hash = hash_of(document, done)
    share = max(samples // max(len(document.trials), 1), FEWEST_SAMPLES)
    trials, told, steps, remarks = list[Trial](), list[CompressionSummary](), list[float](), list[Remark]()
    for entry in document.trials:
        record = _Record(document, entry, trial_columns(document, entry, model), model, done)
        if record.is_short(share):
            trials += read_entry(entry, record.columns, document, model, done, None, remarks)
            continue
        some, said = record.compressed(share)
        remarks += record.remarks
        trials += some
        told.append(said)
        steps.append(said.seconds / (said.rows - 1))
    experiment = assembled(document, tuple(trials), model, data_hash, remarks)
    return Compressed(_with_clocks(experiment, max(steps, default=0.0)), tuple(told))


def _with_clocks(experiment: Experiment, step: float) -> Experiment:
    """How far a channel's clock may be off goes by the samples that were recorded, not by those that are left."""
    if not step:
        return experiment
    outputs = [name for name, signal in experiment.signals.items() if signal.role == "output"]
    stated = {name: experiment.setup_sd.get(name, SetupSd()) for name in outputs}
    clocks = {name: replace(each, clock=step) if each.clock is None else each for name, each in stated.items()}
    return replace(experiment, setup_sd={**experiment.setup_sd, **clocks})


class _Record:
    """One recording on its way."""

    def __init__(self, document: Document, entry: TrialEntry, columns: list[Column], model: Model, done: ShareDone) -> None:
        self.document, self.entry, self.columns, self.model, self.done = document, entry, columns, model, done
        self.names = [column.name for column in columns]
        roles = {name: document.signals[name].role for name in self.names}
        self.inputs, self.outputs = ([name for name in self.names if roles[name] == role] for role in ("input", "output"))
        self.values = {**document.nominal.values, **entry.values}
        self.cycle_time = model.cycle_time(self.values)
        self.remarks = list[Remark]()

    def is_short(self, share: int) -> bool:
        """Whether it stays as it is: it is no longer than its share, or only parts of it count, which a trigger tells."""
        if TRIGGER in self.names:
            return True
        count = 0
        for batch in trial_batches(self.entry, self.columns, lambda more: None, lambda rows: None, self.document.form):
            count += batch[0].size
            if count > share:
                return False
        return True

    def batches(self) -> Iterator[list[FloatArray]]:
        """Checked, in SI."""
        self.remarks = list[Remark]()  # of each pass the same
        some = trial_batches(self.entry, self.columns, self.done, lambda rows: None, self.document.form, self.remarks)
        return derived_batches(self.entry.file, self.columns, some, self.document)

    def compressed(self, share: int) -> tuple[list[Trial], CompressionSummary]:
        """Its trials, and what was done."""
        motion = self.names.index(MOTION) if MOTION in self.names else None
        vibrates = math.isfinite(self.cycle_time)
        demodulation, overview = None, None
        if vibrates:
            demodulation = self._demodulated()
            self.clock = demodulation.times
            course = _in_phase(steady(demodulation, self._told_by()), self.clock, self.cycle_time)
            rows = demodulation.rows
        else:
            overview = Overview(self.batches(), len(self.columns), motion)
            self.clock, rows = overview.times, overview.rows
            course = stretches(overview, [self.names.index(name) for name in self.inputs])
        self.way = overview.ways if overview is not None and motion is not None else self._way_of_cycles()
        pieces = sorted(pieces_of(course, share, overview), key=lambda pair: pair[0].begin)
        for piece, _ in pieces:
            piece.inputs = tuple(self.names.index(name) for name in self.inputs)
        if not pieces:
            raise ExperimentError(
                f"{self.entry.file}: nothing in its {rows} rows repeats itself for {FEWEST_CYCLES} cycles, is held still, or passes so "
                f"slowly that {share} samples can show it. Cut it into trials that do, keep more samples, or have it read as it is."
            )
        self._fill([piece for pair in pieces for piece in pair if piece is not None])
        self.noise = self._noise_of_a_cycle([piece for piece, _ in pieces if piece.stretch.kind == "repeating"])
        trials = [trial for number, (piece, lead) in enumerate(pieces, 1) for trial in self._trials(piece, lead, number)]
        begin, end = (float(time) for time in self.clock(np.array([0.0, rows - 1.0])))
        return trials, CompressionSummary.of(self.entry.file, rows, end - begin, course, pieces, self.names, self.outputs, self.clock)

    def _told_by(self) -> int:
        """The column whose phase counts: an input's, where one is recorded, else the first output's."""
        return self.names.index((self.inputs or self.outputs)[0])

    def _demodulated(self) -> Demodulation:
        turns = expected = 0.0
        for batch in trial_batches(self.entry, self.columns, lambda more: None, lambda rows: None, self.document.form):
            if batch[0].size > 2:
                expected = expected or float(np.median(np.diff(batch[0]))) / self.cycle_time
                turns = frequency(batch[self._told_by()], expected) or 0.0
            if turns:  # it may be a while until it cuts
                break
        return Demodulation(self.batches(), turns or expected)

    def _way_of_cycles(self) -> Callable[[FloatArray], FloatArray]:
        """How far it slides by the nominal model, cycle after cycle."""
        speed = 0.0
        if math.isfinite(self.cycle_time) and any(variable.name == DISTANCE for variable in self.model.variables):
            way = self.model.settled((DISTANCE,), self.document.nominal.effects, self.values)[DISTANCE]
            speed = float(np.nan_to_num(way[0])) / self.cycle_time
        return lambda rows: speed * (self.clock(rows) - self.clock(np.zeros(1)))

    def _fill(self, pieces: Sequence[Piece]) -> None:
        """The second pass."""
        first = 0
        for batch in self.batches():
            for piece in pieces:
                piece.add(first, batch)
            first += batch[0].size

    def _noise_of_a_cycle(self, pieces: Sequence[Piece]) -> dict[str, float]:
        """By output: standard deviation of a point of one cycle, by how the halves of averages differ; 0 where nothing repeats itself."""
        noise = dict.fromkeys(self.outputs, 0.0)
        for name in self.outputs if pieces else ():
            squares = []
            for piece in pieces:
                first, second = piece.averages()[1][:, self.names.index(name)]
                squares.append(np.mean((first - second) ** 2) * (piece.phases[1] - piece.phases[0]) / 4)
            noise[name] = float(np.sqrt(np.median(squares)))
        return noise

    def _trials(self, piece: Piece, lead: Piece | None, number: int) -> list[Trial]:
        if piece.stretch.kind == "repeating":
            return self._average_cycles(piece, number)
        places, values = piece.averages()
        rows = piece.begin + places * (piece.end - piece.begin)
        times, inputs = self.clock(rows), self._inputs(values)
        begin, before = piece.begin, None
        if lead is not None:
            begin, (led, leading) = lead.begin, lead.averages()
            leading_times = self.clock(lead.begin + led * (lead.end - lead.begin))
            before = self._trial(piece, number, leading_times, self._inputs(leading), leading[0], {})
        slid = self._slid(float(begin), 0.0)
        made = [self._trial(piece, number, times, inputs, half, slid, place, before) for place, half in enumerate(values)]
        if len(made) > 1:
            return made
        sd = {name: max(_noise_sd(column), self.noise[name]) for name, column in made[0].outputs.items()}
        averaged = max(float(piece.counts.sum()) / piece.points, 1.0)  # rows a point
        stated = {name: each / math.sqrt(averaged) for name, each in self.entry.noise_sd.items()}  # of one row
        return [replace(made[0], noise_sd={**{name: each for name, each in sd.items() if each > 0}, **stated})]

    def _average_cycles(self, piece: Piece, number: int) -> list[Trial]:
        """Two halves of an average cycle, whose middle is that of its piece, and a cycle before it."""
        places, values = piece.averages()
        first, last = piece.phases
        rows = np.interp([first, (first + last) / 2, last], piece.stretch.phases, piece.stretch.rows)
        begin, centre, end = self.clock(rows)
        cycle = float(end - begin) / (last - first)
        at = float(centre) - cycle / 2
        if math.isfinite(self.cycle_time):  # by the model's clock, which then has the phase that was measured
            at, cycle = round((first + last) / 2) * self.cycle_time, self.cycle_time
        times, inputs = at + places * cycle, self._inputs(values)
        before = self._trial(piece, number, times - cycle, inputs, values.mean(axis=0), {})
        slid = self._slid(float(rows[1]), 1.5 * float(rows[2] - rows[0]) / (last - first))
        return [self._trial(piece, number, times, inputs, half, slid, place, before) for place, half in enumerate(values)]

    def _slid(self, row: float, before: float) -> dict[str, float]:
        """How far the contact had slid at a row less what it slides in `before` rows there: in the record, and before it where that is
        stated."""
        if not any(variable.name == DISTANCE for variable in self.model.variables):
            return {}
        stated = float(self.entry.values.get(DISTANCE, 0.0))
        begin, end = self.way(np.array([max(row - before, 0.0), row]))
        return {DISTANCE: stated + float(begin)} if end > 0 else {DISTANCE: stated}

    def _inputs(self, values: FloatArray) -> dict[str, FloatArray]:
        """Of both halves together, so that they are one run."""
        table = values.mean(axis=0)
        return {name: table[self.names.index(name)].copy() for name in self.inputs}

    def _trial(
        self,
        piece: Piece,
        number: int,
        times: FloatArray,
        inputs: dict[str, FloatArray],
        table: FloatArray,
        slid: dict[str, float],
        half: int = 0,
        lead_in: Trial | None = None,
    ) -> Trial:
        """table : (columns, points). No noise is stated of averages in two halves, which tell it; its owner stated that of a row."""
        path = PurePosixPath(self.entry.file)
        file = str(path.with_name(f"{path.stem}-{number:02d}{'ab'[half]}{path.suffix}"))
        outputs = {name: table[self.names.index(name)].copy() for name in self.outputs}
        begin = float(self.clock(np.array([float(piece.begin)]))[0])
        condition = f"{self.entry.condition}, {number}: {piece.stretch.kind} at {begin:.4g} s"
        return Trial(file, condition, {**self.entry.values, **slid}, times, inputs, outputs, lead_in)


def _in_phase(course: list[Stretch], clock: Callable[[FloatArray], FloatArray], cycle_time: float) -> list[Stretch]:
    """Phases counted as the model does, which has them by the clock: as many cycles as its clock says at the first row of the record."""
    first = next((each for each in course if each.kind == "repeating"), None)
    if first is None:
        return course
    turns = float(first.phases[-1] - first.phases[0]) / float(first.rows[-1] - first.rows[0])
    at_begin = float(first.phases[0]) - turns * float(first.rows[0])
    late = float(clock(np.zeros(1))[0]) / cycle_time - at_begin
    return [replace(each, phases=each.phases + late) if each.kind == "repeating" else each for each in course]


def _noise_sd(column: FloatArray) -> float:
    """Of the samples of a transient (n,), as their second differences have it: of noise that is fast."""
    return float(1.4826 * np.median(np.abs(np.diff(column, 2))) / np.sqrt(6)) if column.size > 4 else 0.0
