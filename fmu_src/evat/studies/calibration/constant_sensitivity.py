"""What do half and twice each constant of the diagnosis do to what it says of a stored set of cases?

The cases are small experiments whose truth is known, each given by its number alone. Every constant is replaced on its own. A diagnosis
forks where it first reads a constant, so that only what comes after is computed again; one that a case never reads has no say in it.
Answer after answer is appended to a file, so that a campaign goes on where it was stopped.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from evat.constants import CONSTANTS, Value
from evat.experiment import Experiment
from evat.files.writing import as_output_error, put, usable
from evat.gap import diagnose_with
from evat.gap.report.explanation import explain
from evat.gap.report.summary import headline
from evat.gap.verdict.calibrate import CalibrationCase, probability
from evat.gap.verdict.constants import in_use
from evat.gap.verdict.judgement import MISTUNED, NO_GAP, UNKNOWN
from evat.gap.verdict.sensitivity import STORED, read
from evat.inference.hypothesis import Hypothesis
from evat.model import EvatError, Model, ParameterError
from evat.processes import process_pool
from evat.studies.calibration import small_cases
from evat.studies.calibration.campaign import kernel_digest
from evat.studies.calibration.forks import can_fork, with_forks

CASES = tuple(small_cases.CASES)
FACTORS = (0.5, 2.0)
LEAST_PROBABILITY = 1e-3  # of the truth: a case counts no worse
FORMAT = 2  # of a line of the campaign's file
Key = tuple[int, str, float]  # number of a case, constant, factor; ("", 1.0) is the case as it is


@dataclass(frozen=True)
class Outcome:
    """Of one case: `log_loss`, minus the log of what the truth was given; `right`, whether the verdict says it; `answer`, a digest of all
    that was said, in figures and words; `reads`, which constants were read, where nothing was replaced."""

    log_loss: float
    right: bool
    answer: str
    reads: tuple[str, ...] = ()


def table_digest() -> str:
    """Of the values that all constants have: with others every outcome is another."""
    return hashlib.sha256(json.dumps(in_use(), sort_keys=True).encode()).hexdigest()[:16]


class KnownCase:
    """An experiment whose truth is known, diagnosed with this and that constant replaced."""

    def __init__(self, experiment: Experiment, truth: str, model: Model) -> None:
        self.experiment, self.truth, self.model = experiment, truth, model

    def outcome(self) -> Outcome:
        """With all constants as they are now; EvatError where the diagnosis does not run."""
        with CONSTANTS.reading() as reads, threadpool_limits(1):
            answer, comparison = diagnose_with(self.experiment, self.model)
            said = [answer.json(), str(headline(answer, comparison)), *(explain(comparison, answer, e.name) for e in self.model.effects)]
        judgement = answer.judgement
        given = probability(CalibrationCase(judgement.features, self.truth), judgement.constants)
        named = self.truth in (NO_GAP, MISTUNED, UNKNOWN)
        right = answer.verdict == self.truth if named else judgement.chosen == Hypothesis(tuple(self.truth.split("+")))
        digest = hashlib.sha256("\n".join(said).encode()).hexdigest()[:16]
        return Outcome(-math.log(max(given, LEAST_PROBABILITY)), right, digest, tuple(sorted(reads)))

    def with_replaced(self, name: str, factor: float) -> Outcome:
        """From the beginning on; `each_replaced` gives the same."""
        with CONSTANTS.replaced(**{name: _times(name, factor)}):
            return replace(self.outcome(), reads=())

    def each_replaced(self, wanted: Sequence[tuple[str, float]], tell: Callable[[tuple[str, float], Outcome | str], None]) -> None:
        """The outcome as it is, whose key is ("", 1.0), and of each that is wanted; or why there is none."""
        factors: dict[str, list[float]] = {}
        for name, factor in wanted:
            factors.setdefault(name, []).append(factor)
        values = {name: [_times(name, factor) for factor in own] for name, own in factors.items()} if can_fork() else {}
        done = set[tuple[str, float]]()

        def forked(name: str, place: int, answer: dict[str, Any]) -> None:
            key = name, factors[name][place]
            tell(key, _held({**answer, "reads": ()}))
            done.add(key)

        as_it_is = _held(with_forks(self._answer, values, forked))
        tell(("", 1.0), as_it_is)
        for name, factor in (key for key in wanted if key not in done):
            if isinstance(as_it_is, str) or name not in as_it_is.reads:
                tell((name, factor), as_it_is if isinstance(as_it_is, str) else replace(as_it_is, reads=()))
            else:
                with CONSTANTS.replaced(**{name: _times(name, factor)}):
                    tell((name, factor), _held({**self._answer(), "reads": ()}))

    def _answer(self) -> dict[str, Any]:
        try:
            return dict(vars(self.outcome()))
        except EvatError as error:
            return {"error": str(error)[:200]}


def _held(entry: Mapping[str, Any]) -> Outcome | str:
    """What was written of an outcome, or why there is none."""
    return str(entry["error"]) if "error" in entry else Outcome(**{**entry, "reads": tuple(entry["reads"])})


def _times(name: str, factor: float) -> Value:
    return CONSTANTS.declared()[name].times(factor, in_use()[name])


def _run(number: int, wanted: Sequence[tuple[str, float]], tell: Callable[[Key, Outcome | str], None]) -> None:
    """The outcome of each, as soon as it is there."""
    if number not in small_cases.CASES:
        raise ParameterError(f"case {number}: there are {', '.join(map(str, CASES))}.")
    KnownCase(*small_cases.CASES[number]()).each_replaced(wanted, lambda key, outcome: tell((number, *key), outcome))


def _lines(number: int, wanted: Sequence[tuple[str, float]], path: Path) -> int:
    """Run in a process of its own: each outcome is a line of the file as soon as it is there."""
    count, made = 0, _made()

    def tell(key: Key, outcome: Outcome | str) -> None:
        nonlocal count
        said = {"error": outcome} if isinstance(outcome, str) else vars(outcome)
        with as_output_error(path, "the outcome"), path.open("a", encoding="utf-8") as file:
            file.write(json.dumps({"key": key, **made, **said}, sort_keys=True) + "\n")
        count += 1

    _run(number, wanted, tell)
    return count


def _made() -> dict[str, Any]:
    return {"kernel": kernel_digest(), "table": table_digest(), "format": FORMAT}


def outcomes(path: Path) -> dict[Key, Outcome | str]:
    """What a campaign's file has of this kernel and these constants; a line that is cut off or damaged is none."""
    held: dict[Key, Outcome | str] = {}
    made = _made()
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines() if path.is_file() else ():
        try:
            entry = json.loads(line)
            if {name: entry.pop(name) for name in made} == made:
                number, name, factor = entry.pop("key")
                held[number, name, factor] = _held(entry)
        except (ValueError, KeyError, TypeError, AttributeError):
            continue
    return held


def named(patterns: Iterable[str]) -> list[str]:
    """The constants that have such names, with * and ? as in file names, in the order of the table; ParameterError where none has."""
    declared = CONSTANTS.declared()
    patterns = list(patterns)
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in declared):
            raise ParameterError(f"constant {pattern!r}: there is none of that name; the guide's page on constants lists them.")
    return [name for name in declared if any(fnmatchcase(name, pattern) for pattern in patterns)]


def campaign(
    path: Path, names: Iterable[str], workers: int, cases: Sequence[int] = CASES, tell: Callable[[int], None] | None = None
) -> dict[Key, Outcome | str]:
    """Half and twice each constant over the cases; what the file has already is not run again."""
    names = list(names)
    if unknown := [name for name in names if name not in CONSTANTS.declared()]:
        raise ParameterError(f"constant {', '.join(unknown)}: there is none of that name; evat.constants lists them.")
    usable(path.parent)
    held = outcomes(path)
    missing = {number: [(name, factor) for name in names for factor in FACTORS if (number, name, factor) not in held] for number in cases}
    missing = {number: wanted for number, wanted in missing.items() if wanted or (number, "", 1.0) not in held}
    with process_pool(workers) as pool:
        for place, _ in enumerate(pool.map(_lines, missing, missing.values(), [path] * len(missing)), 1):
            if tell:
                tell(len(cases) - len(missing) + place)
    return outcomes(path)


def column(held: Mapping[Key, Outcome | str], names: Iterable[str], cases: Sequence[int] = CASES) -> dict[str, Any]:
    """What the campaign says of each constant: the change of the mean log loss over the cases, that of the number of right verdicts,
    how many answers change in any figure, and how many cases no longer run (they count as if the truth had been given nothing)."""
    before = {number: held[number, "", 1.0] for number in cases}
    nothing = -math.log(LEAST_PROBABILITY)
    rows = {}
    for name in names:
        row: dict[str, Any] = {"value": in_use()[name], "cases": list(cases), "read_in": sum(name in _of(before[n]).reads for n in cases)}
        for word, factor in zip(("halved", "doubled"), FACTORS, strict=True):
            after = [held[number, name, factor] for number in cases]
            loss = sum((nothing if isinstance(o, str) else o.log_loss) - _of(before[n]).log_loss for n, o in zip(cases, after, strict=True))
            right = sum((not isinstance(o, str) and o.right) - _of(before[n]).right for n, o in zip(cases, after, strict=True))
            row[word] = {
                "value": CONSTANTS.declared()[name].times(factor, in_use()[name]),
                "log_loss": round(loss / len(cases), 4),
                "right": right,
                "changed": sum(isinstance(o, str) or o.answer != _of(before[n]).answer for n, o in zip(cases, after, strict=True)),
                "failed": sum(isinstance(o, str) for o in after),
            }
        rows[name] = row
    return rows


def store(held: Mapping[Key, Outcome | str], names: Iterable[str], cases: Sequence[int] = CASES, path: Path = STORED) -> None:
    """Keep the column in the package, beside what was kept before. Each row says of which kernel and values of all constants it is; one of
    the same that was tried on more cases before stays, one of a constant that is gone goes."""
    made = {"kernel": kernel_digest(), "table": table_digest()}
    rows = {name: row for name, row in read(path).get("constants", {}).items() if name in CONSTANTS.declared()}
    for name, row in column(held, names, cases).items():
        before = rows.get(name, {})
        if before.get("made") != made or len(row["cases"]) >= len(before["cases"]):
            rows[name] = {**row, "made": made}
    put(path, json.dumps({"constants": rows}, indent=1, sort_keys=True) + "\n", "the sensitivity")


def _of(outcome: Outcome | str) -> Outcome:
    if isinstance(outcome, str):
        raise EvatError(f"a case does not run as it is: {outcome}")
    return outcome
