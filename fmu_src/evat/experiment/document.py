"""What does an experiment.toml say? Its keys checked against the format and the model; no data file is opened here."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Any

from evat.experiment import ExperimentError, Nominal, Role, SetupSd, Signal
from evat.experiment.checks import MOST, SETTABLE, Checks, is_number, is_size, shown
from evat.experiment.keys import keys, needed
from evat.experiment.nominal import INERTIA, read_nominal
from evat.files.read_toml import TomlError, read_toml
from evat.files.text import PLAIN, TextForm, known_encoding
from evat.model import Model, ParameterError, Variable
from evat.required_inputs import KINEMATICS, MOTION, PROXY, lacks_motion
from evat.units import affine, base_unit

FILE = "experiment.toml"
FORMAT = 1
DATA_FILES = (".csv", ".tsv", ".txt", ".parquet", ".h5", ".mat")
CLOCK = "time"
TRIGGER = "trigger"  # a signal that is on in the rows that count
BESIDE = (CLOCK, TRIGGER)  # signals that are no variables of the component
FRICTION = "friction_force"
MEAN = "mean_"  # how the names of averages begin
MOST_LINES = 100_000  # above the numbers

POSITION = "position"
ANGULAR = {"m/s": "rad/s", "N": "N.m"}  # what a column with a lever arm measures in place of the variable


@dataclass(frozen=True, slots=True)
class TrialEntry:
    """One of [[trials]]: where its data lie; nothing of them is read. `file` is what the recording is called, `source` what its file is, of
    which only the `rows` count in which columns have these values."""

    file: str
    path: Path
    condition: str
    values: Mapping[str, float]
    noise_sd: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
    rows: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Inertia:
    """What a force beside the contact's own measures: `mass` [kg] times the acceleration of the slip, and a `load` [N]."""

    mass: float
    load: float


@dataclass(frozen=True, slots=True)
class Document:
    """All that stands in the file. `files` are the document, the parameter file if there is one, and every data file, in that order."""

    folder: Path
    title: str
    intended_use: str
    nominal: Nominal
    signals: Mapping[str, Signal]
    trials: tuple[TrialEntry, ...]
    means: tuple[str, Path] | None
    files: tuple[Path, ...]
    setup_sd: Mapping[str, SetupSd]
    inertia: Inertia | None = None
    form: TextForm = PLAIN
    ignored: tuple[str, ...] = ()

    @property
    def recorded(self) -> tuple[Signal, ...]:
        """The signals that each trial's file has a column of: all, but for averages where there is a file of them."""
        of_trials = (signal for name, signal in self.signals.items() if self.means is None or not name.startswith(MEAN))
        return tuple(of_trials) if self.trials else ()

    @property
    def averaged(self) -> tuple[Signal, ...]:
        """The signals that the file of averages must have a column of."""
        of_means = (signal for name, signal in self.signals.items() if name.startswith(MEAN) or (not self.trials and name != CLOCK))
        return tuple(of_means) if self.means is not None else ()


def read_document(folder_or_toml: Path, model: Model) -> Document:
    """The experiment.toml of a folder, or such a file itself; ExperimentError names key or entry, what was found and what is allowed."""
    path = folder_or_toml / FILE if folder_or_toml.is_dir() else folder_or_toml
    if not path.is_file():
        begin = f"evat experiment init {folder_or_toml} makes one from the data files there"
        todo = begin if folder_or_toml.is_dir() else "check the spelling"
        raise ExperimentError(f"{path}: there is no such file; an experiment is a folder with a file {FILE} in it; {todo}.")
    if path.suffix.lower() in DATA_FILES:
        raise ExperimentError(f"{path}: that is a file of data; name the folder in which {FILE} says what its columns are.")
    return _Reader(path, model).document()


class _Reader(Checks):
    """One reading of one document."""

    def document(self) -> Document:
        try:
            table = read_toml(self.path)
        except TomlError as error:
            raise ExperimentError(str(error)) from error
        self.keys("", table, keys(""), needed(""))
        if table["format"] != FORMAT or isinstance(table["format"], bool):
            raise self.error("format", f"{shown(table['format'])}; this version reads format {FORMAT}.")
        signals = self.signals(self.table("signals", table.get("signals", {})))
        entries = table.get("trials", [])
        if not isinstance(entries, list):
            raise self.error("trials", "write each recording as a table [[trials]], with two brackets.")
        trials = tuple(self.trial(f"trials {place + 1}", entry) for place, entry in enumerate(entries))
        form = self.form(self.table("reader", table.get("reader", {})))
        clock = signals.get(CLOCK)
        if form.timestamp and (clock is None or clock.column != form.timestamp or clock.unit != "s"):
            raise self.error("reader.timestamp", f'{shown(form.timestamp)}; it must be signals.{CLOCK}.column, whose unit then is "s".')
        means, ignored = None, tuple[str, ...]()
        if "means" in table:
            self.keys("means", self.table("means", table["means"]), keys("[means]"), needed("[means]"))
            means = (file := self.text("means.file", table["means"]["file"]), self.inside("means.file", file))
            ignored = self.ignored(table["means"].get("ignore", []))
        self.contents(signals, trials, means)
        believed = dict(self.table("nominal", table["nominal"]))
        inertia = self.inertia(believed, signals)
        nominal, files = read_nominal(self, believed)
        title, intended_use = (self.text(key, table.get(key, "")) for key in ("title", "intended_use"))
        self.motion(nominal, signals, trials)
        data = self.data(trials, means)
        setup_sd = self.setup_sd(self.table("setup_sd", table.get("setup_sd", {})), signals)
        return Document(
            self.path.parent,
            title,
            intended_use,
            nominal,
            signals,
            trials,
            means,
            (self.path, *files, *data),
            setup_sd,
            inertia,
            form,
            ignored,
        )

    def data(self, trials: Sequence[TrialEntry], means: tuple[str, Path] | None) -> list[Path]:
        """The data files, each once; whether a recording is named twice."""
        whole = Counter([entry.path for entry in trials if not entry.rows] + ([means[1]] if means else []))
        parts = Counter((entry.path, tuple(sorted(entry.rows.items()))) for entry in trials if entry.rows)
        twice = [path for path, count in whole.items() if count + any(path == of for of, _ in parts) > 1]
        twice += [path for (path, _), count in parts.items() if count > 1]
        if twice:
            raise self.error(
                "",
                f"{twice[0].relative_to(self.root)} is named twice; each recording counts once; repeats have files or `rows` of their own.",
            )
        return list(dict.fromkeys([*(entry.path for entry in trials), *([means[1]] if means else [])]))

    def form(self, table: Mapping[str, Any]) -> TextForm:
        """How the text files are written."""
        self.keys("reader", table, keys("[reader]"), ())
        for key in ("skip_rows", "rows_after_header"):
            if not isinstance(count := table.get(key, 0), int) or isinstance(count, bool) or not 0 <= count <= MOST_LINES:
                raise self.error(f"reader.{key}", f"{shown(count)}; a whole number of lines from 0 to {MOST_LINES} is needed.")
        delimiter, decimal, encoding = (self.text(f"reader.{key}", table.get(key, "")) for key in ("delimiter", "decimal", "encoding"))
        self.text("reader.timestamp", table.get("timestamp", ""))
        if "delimiter" in table and (len(delimiter) != 1 or not delimiter.isascii() or delimiter in '"\n\r\0' or delimiter.isalnum()):
            raise self.error("reader.delimiter", f'{shown(delimiter)}; one character between columns is needed, such as ";" or "\\t".')
        if decimal not in ("", ".", ","):
            raise self.error("reader.decimal", f"{shown(decimal)}; allowed are '.' and ','.")
        if decimal == delimiter == ",":
            raise self.error("reader.decimal", "',' stands between the columns, too; one of them must be something else.")
        if encoding and not known_encoding(encoding):
            raise self.error("reader.encoding", f"{shown(encoding)}; no such encoding of text, write it like utf-8, cp1252 or utf-16.")
        columns = table.get("columns", [])
        if not isinstance(columns, list) or not all(isinstance(name, str) for name in columns):
            raise self.error("reader.columns", f'{shown(columns)}; a list of headers is needed, such as ["t", "v", "F"].')
        if twice := [name for name in columns if name and columns.count(name) > 1]:
            raise self.error("reader.columns", f"{twice[0]!r} stands there twice; give each column a header of its own.")
        return TextForm(**{key: table[key] for key in keys("[reader]") if key in table} | {"columns": tuple(columns)})

    def ignored(self, names: Any) -> tuple[str, ...]:
        if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
            raise self.error("means.ignore", f'{shown(names)}; a list of headers is needed, such as ["remark"].')
        return tuple(names)

    def setup_sd(self, table: Mapping[str, Any], signals: Mapping[str, Signal]) -> dict[str, SetupSd]:
        """Of the channels that are named: gain as a number, zero in the unit of the signal, clock in that of the time."""
        setups = {}
        for name, entry in table.items():
            where = f"setup_sd.{name}"
            causality = self.variable(where, name).causality
            if causality not in ("output", "input") or name == PROXY:
                raise self.error(
                    where,
                    "set-up errors are those of what was recorded; name an output or an input, not the temperature proxy, whose zero is "
                    "one with the values at its reference.",
                )
            self.keys(where, self.table(where, entry), keys("[setup_sd.NAME]"), ())
            if causality == "input" and set(entry) - {"zero"}:
                raise self.error(
                    where,
                    f"only the zero of {name} is a set-up error: its gain is one of the law's parameters, its clock that of the force. "
                    "State `zero`, or a clock for the force.",
                )
            known = {}
            for key, number in entry.items():
                if not is_size(number, 0):
                    raise self.error(
                        f"{where}.{key}", f"{shown(number)}; a standard deviation from 0 to {MOST:g} is needed; 0 means exact."
                    )
                signal = signals.get({"zero": name, "clock": CLOCK}.get(key, ""))
                known[key] = float(number)
                if signal is not None:
                    known[key] *= abs(to_variable(signal, "s" if key == "clock" else self.variables[name].unit)[0])
            setups[name] = SetupSd(**known)
        return setups

    def inertia(self, believed: dict[str, Any], signals: Mapping[str, Signal]) -> Inertia | None:
        """Mass and load of what moves; taken out of the table [nominal]."""
        stated = {key: believed.pop(key) for key in INERTIA if key in believed}
        for key, number in stated.items():
            if not is_size(number, 0 if key == "mass" else -MOST):
                unit = "kg of at least 0 and" if key == "mass" else "N of"
                raise self.error(f"nominal.{key}", f"{shown(number)}; a number in {unit} at most {MOST:g} is needed.")
        for name in (MOTION, FRICTION) if stated else ():
            if name not in signals:
                raise self.error("nominal", f"mass and gravity_load are taken off {FRICTION} along {MOTION}; {name} is no signal.")
        return Inertia(float(stated.get("mass", 0.0)), float(stated.get("gravity_load", 0.0))) if stated else None

    def contents(self, signals: Mapping[str, Signal], trials: Collection[TrialEntry], means: tuple[str, Path] | None) -> None:
        """Whether there is anything measured at all."""
        if not trials and means is None:
            raise self.error("", "there are neither [[trials]] nor [means]; name at least one recording or a file of averages.")
        if trials and CLOCK not in signals:
            raise self.error("signals", f"the clock is missing; add [signals.{CLOCK}] with column and unit.")
        for name in signals:
            if trials and name not in BESIDE and self.variables[name].causality == "parameter":
                raise self.error(f"signals.{name}", "a parameter does not vary within a recording; give it among the values of each trial.")
        outputs = [name for name, signal in signals.items() if signal.role == "output" and (means is None or not name.startswith(MEAN))]
        if trials and not outputs:
            raise self.error("signals", 'there is no output, so nothing was measured; give at least one signal role = "output".')

    def motion(self, nominal: Nominal, signals: Mapping[str, Signal], trials: Iterable[TrialEntry]) -> None:
        """Whether each trial has the inputs that its kinematics and effects need."""
        for trial in trials:
            given = {name for name, signal in signals.items() if signal.role == "input"}
            check_inputs(self.model, nominal, given | set(trial.values), f"{self.path.name}, {trial.file}")

    def signals(self, table: Mapping[str, Any]) -> dict[str, Signal]:
        signals = {name: self.signal(name, self.table(f"signals.{name}", entry)) for name, entry in table.items()}
        first: dict[str, str] = {}
        for name, signal in signals.items():
            if signal.column in first:
                raise self.error(
                    f"signals.{name}", f"column {signal.column!r} already is {first[signal.column]}; each signal has a column of its own."
                )
            first[signal.column] = name
        return signals

    def signal(self, name: str, table: Mapping[str, Any]) -> Signal:
        where = f"signals.{name}"
        # a trigger is asked where it is on alone, whatever its unit
        self.keys(where, table, keys("[signals.NAME]"), () if name == TRIGGER else needed("[signals.NAME]"))
        known = self.variable(where, name) if name not in BESIDE else None
        unit, role = self.text(f"{where}.unit", table.get("unit", "1")), table.get("role")
        self.check_role(where, known, role)
        converted = self.conversion(where, known, table)
        signal = Signal(name, self.text(f"{where}.column", table.get("column", name)), unit, role, **converted)
        try:
            factor, _ = to_variable(signal, known.unit if known else "s" if name == CLOCK else unit)
        except ParameterError as error:
            raise self.error(f"{where}.unit", str(error)) from error
        full_scale = table.get("full_scale")
        if full_scale is not None:
            if not is_size(full_scale) or full_scale <= 0 or role != "output":
                raise self.error(
                    f"{where}.full_scale",
                    f"{shown(full_scale)}; a number above 0 in {unit} is needed, up to {MOST:g}, and only outputs have one.",
                )
            full_scale = abs(full_scale * factor)  # either way from what the sensor shows of nothing, which is at `offset`
        return replace(signal, full_scale=full_scale)

    def conversion(self, where: str, known: Variable | None, table: Mapping[str, Any]) -> dict[str, Any]:
        """How a column becomes the variable, beside its unit."""
        keys = [key for key in ("sign", "scale", "offset", "from", "radius") if key in table]
        if known is None and keys:
            raise self.error(f"{where}.{keys[0]}", "the clock and the trigger are read as they are; remove it.")
        if table.get("sign", 1) not in (1, -1) or isinstance(table.get("sign"), bool):
            raise self.error(f"{where}.sign", f"{shown(table['sign'])}; allowed are 1 and -1.")
        for key in ("scale", "offset"):
            number = table.get(key, 1.0)
            if not is_size(number) or (key == "scale" and number == 0):
                but = ", not 0" if key == "scale" else ""
                raise self.error(f"{where}.{key}", f"{shown(number)}; a finite number is needed{but}, of at most {MOST:g} either way.")
        of = table.get("from", "")
        if of not in ("", POSITION):
            raise self.error(f"{where}.from", f"{shown(of)}; allowed is {POSITION!r}.")
        if of and (known is None or known.unit != "m/s"):
            raise self.error(f"{where}.from", f"{known.name if known else CLOCK} is no velocity; only a velocity is taken from a position.")
        if of and table.get("offset"):
            raise self.error(
                f"{where}.offset",
                f"{shown(table['offset'])}, added to a position: that changes no velocity. Remove it; how far the zero of a recorded "
                f"motion may be off is setup_sd.{known.name if known else ''}.zero.",
            )
        scale = table.get("scale")
        return {
            "sign": int(table.get("sign", 1)),
            "scale": None if scale is None else float(scale),
            "offset": float(table.get("offset", 0.0)),
            "of": of,
            "radius": self.radius(where, known, table),
        }

    def radius(self, where: str, known: Variable | None, table: Mapping[str, Any]) -> float | None:
        """The lever arm [m] of a column that is an angle, an angular velocity or a torque."""
        number = table.get("radius")
        if number is None:
            return None
        if not is_size(number) or number <= 0:
            raise self.error(f"{where}.radius", f"{shown(number)}; a lever arm above 0 in m is needed, up to {MOST:g}.")
        if known is None or known.unit not in ANGULAR:
            raise self.error(f"{where}.radius", "only a velocity has an angular one, and a force a torque; remove it.")
        if "scale" in table:
            raise self.error(f"{where}.radius", "there is a scale, too; keep one of them.")
        return float(number)

    def check_role(self, where: str, known: Variable | None, role: Role | None) -> None:
        if known is None:
            if role is not None:
                name = "clock" if where.endswith(CLOCK) else TRIGGER
                raise self.error(f"{where}.role", f"{shown(role)}; the {name} has no role, remove it.")
            return
        if known.causality not in (*SETTABLE, "output") or known.type != "real":
            raise self.error(
                where, f"this is a {known.causality} ({known.type}) of the component; inputs and outputs that are numbers can be measured."
            )
        right = "output" if known.causality == "output" else "input"
        if role != right:
            wrong = "the role is missing" if role is None else f"role = {shown(role)}"
            raise self.error(f"{where}.role", f'{wrong}; {known.name} is an {right} of the component: role = "{right}".')

    def trial(self, where: str, entry: Any) -> TrialEntry:
        self.keys(where, self.table(where, entry), keys("[[trials]]"), needed("[[trials]]"))
        file, condition = self.text(f"{where}.file", entry["file"]), self.text(f"{where}.condition", entry["condition"])
        if not condition.strip():
            raise self.error(f"{where}.condition", "it is empty; trials of one condition are repeats of each other, so name it.")
        values = {}
        for key, number in self.numbers(f"{where}.values", entry.get("values", {})):
            if key in self.integrals:
                values[key] = self.begun_at(f"{where}.values.{key}", number)
                continue
            if self.settable(f"{where}.values.{key}", key).type != "real":
                raise self.error(f"{where}.values.{key}", "only numbers vary from trial to trial; choices stand in [nominal].")
            values[key] = float(self.value(f"{where} ({file}), values.{key}", key, number))
        noise_sd = {}
        for channel, number in self.table(f"{where}.noise_sd", entry.get("noise_sd", {})).items():
            if self.variable(f"{where}.noise_sd", channel).causality != "output":
                raise self.error(f"{where}.noise_sd.{channel}", "noise is that of what was measured; name an output.")
            if not is_size(number) or number <= 0:
                raise self.error(
                    f"{where}.noise_sd.{channel}", f"{shown(number)}; a standard deviation above 0 is needed, up to {MOST:g} in SI."
                )
            noise_sd[channel] = float(number)
        rows = dict(self.table(f"{where}.rows", entry.get("rows", {})))
        for header, number in rows.items():
            if not is_number(number) or not math.isfinite(number):
                raise self.error(f"{where}.rows", f"{shown(header)} = {shown(number)}; a number is needed, such as that of a run.")
        return TrialEntry(part_name(file, rows), self.inside(f"{where}.file", file), condition, values, noise_sd, file, rows)


def part_name(file: str, rows: Mapping[str, float]) -> str:
    """What a recording is called that is some rows of a file: all.csv with run = 2 is all-run-2.csv."""
    path = PurePosixPath(file)
    words = [re.sub(r"\W+", "-", f"{header} {value:g}").strip("-") for header, value in rows.items()]
    return str(path.with_name(f"{'-'.join([path.stem, *words])}{path.suffix}")) if rows else file


def to_variable(signal: Signal, wanted: str) -> tuple[float, float]:
    """factor and offset with variable = factor value + offset, value as it stands in the file; ParameterError where the unit does not fit.
    Of a velocity that is taken from a position, those of the position."""
    if signal.radius is not None:
        factor, offset = affine(signal.unit, "rad" if signal.of else ANGULAR[wanted])
        scale = signal.radius if signal.of or wanted == "m/s" else 1 / signal.radius
        return signal.sign * scale * factor, signal.sign * scale * offset + signal.offset
    if signal.scale is None:
        factor, offset = affine(signal.unit, "m" if signal.of else wanted)
        scale = 1.0
    else:
        base = base_unit(signal.unit)
        factor, offset, scale = float(base.factor), float(base.offset), signal.scale
    return signal.sign * scale * factor, signal.sign * scale * offset + signal.offset


def turn_of(signal: Signal) -> float | None:
    """A whole turn of an angle that is differentiated, as `to_variable` has it; None of what is none."""
    if not signal.of or base_unit(signal.unit).exponents != base_unit("rad").exponents:
        return None
    factor, _ = to_variable(signal, "m/s")
    return abs(factor) * math.tau / affine(signal.unit, "rad")[0]


def check_inputs(model: Model, nominal: Nominal, given: Collection[str], where: str) -> None:
    """ExperimentError where the nominal model needs an input that is neither a signal nor has a value."""
    if lacks_motion(model, nominal.values, given):
        kinematics = nominal.values[KINEMATICS]
        raise ExperimentError(
            f"{where}: kinematics = {kinematics} takes the motion from {MOTION}, which is neither a signal nor has a value."
        )
    for name, effects in model.missing_inputs(nominal.effects, nominal.values, given).items():
        raise ExperimentError(
            f"{where}: the nominal model's {', '.join(effects)} cannot act without {name}, which is neither a signal nor has a value. "
            "Give it, or take what needs it out of the nominal model."
        )
