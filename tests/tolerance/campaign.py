"""How far is the kernel from the right answer over thousands of draws? Runs them, or one of them by its number.

python tests/tolerance/campaign.py --count 300 --seed 1
python tests/tolerance/campaign.py --seed 1 --draw 17
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import numpy as np
from draws import draw
from judged import FORCES, MEANS, MEASURED, POWERS, TOTALS, Care, Judgement, judge, sensitivity, slips

ALL = (*FORCES, *MEASURED, *MEANS, *POWERS, *TOTALS, "bristle_deflection")


@dataclass(frozen=True)
class Line:
    """What is kept of a draw."""

    number: int
    kind: str
    law: str
    on: tuple[str, ...]
    tolerance: float
    stepped: bool
    verdict: str  # of the reference
    status: str  # of the kernel
    friction: float  # largest error in tolerances
    any: float  # of any output
    output: str  # which
    steps: int
    seconds: float
    reference_seconds: float
    moves: float = 0.0  # the right answer, in tolerances, where what is given moves by one; asked only beyond FAR
    slips: int = 1  # the most that go with one state; asked only beyond FAR


FAR = 10  # tolerances, which no judged draw may be away


def line(seed: int, number: int, care: Care | None = None) -> Line:
    """One draw, judged."""
    judgement = judge(draw(seed, number), care)
    case, errors = judgement.case, {name: judgement.worst([name]) for name in ALL if name in judgement.names}
    output = max(errors, key=lambda name: errors[name])
    far = [name for name in (output, "friction_force") if errors[name] > FAR]
    moves = [sensitivity(case, judgement.reference, name, care) for name in dict.fromkeys(far)]
    return Line(
        number,
        case.kind,
        case.law,
        case.on,
        case.relative_tolerance,
        case.motion.stepped,
        judgement.reference.verdict,
        judgement.answer.status,
        errors["friction_force"],
        errors[output],
        output,
        judgement.answer.steps,
        judgement.answer.seconds,
        judgement.reference.seconds,
        min(moves, default=0.0),
        slips(case, care) if far else 1,
    )


def run(seed: int, first: int, count: int, care: Care | None = None) -> list[Line]:
    """Draws one after another."""
    return [line(seed, number, care) for number in range(first, first + count)]


def is_solved(line: Line) -> bool:
    return line.verdict == "done" and line.status == "done"


def is_ill_conditioned(line: Line) -> bool:
    """Far from the right answer, which itself moves as far where what is given moves by a tolerance."""
    return is_solved(line) and line.moves > FAR


def is_ambiguous(line: Line) -> bool:
    """Far from one right answer where the equations have another."""
    return is_solved(line) and line.slips > 1


def is_judged(line: Line) -> bool:
    return is_solved(line) and not is_ill_conditioned(line) and not is_ambiguous(line)


def table(title: str, lines: Sequence[Line], groups: Iterable[tuple[str, Callable[[Line], bool]]], error: str = "any") -> str:
    """Percentiles of the error by group: of any output, or of friction alone."""
    head = (
        f"{title:<24}{'draws':>7}{'p50':>9}{'p90':>9}{'p99':>9}{'max':>10}{'>3':>7}{'>10':>7}{'steps p50':>11}{'max':>9}{'worst draw':>12}"
    )
    rows = [head]
    for name, member in groups:
        some = [one for one in lines if is_judged(one) and member(one)]
        if not some:
            continue
        errors = np.array([getattr(one, error) for one in some])
        steps = np.array([one.steps for one in some])
        p50, p90, p99 = np.percentile(errors, [50, 90, 99])
        worst = some[int(np.argmax(errors))]
        rows.append(
            f"{name:<24}{len(some):>7}{p50:>9.3g}{p90:>9.3g}{p99:>9.3g}{errors.max():>10.4g}{int(np.sum(errors > 3)):>7}"
            f"{int(np.sum(errors > 10)):>7}{np.median(steps):>11.0f}{steps.max():>9}{worst.number:>12}"
        )
    return "\n".join(rows)


def _groups(lines: Sequence[Line]) -> Iterable[tuple[str, list[tuple[str, Callable[[Line], bool]]]]]:
    yield "all", [("all", lambda one: True)]
    yield "kind", [(kind, lambda one, kind=kind: one.kind == kind) for kind in sorted({one.kind for one in lines})]
    yield "law", [(law, lambda one, law=law: one.law == law) for law in sorted({one.law for one in lines})]
    effects = sorted({name for one in lines for name in one.on})
    yield "effect", [("none", lambda one: not one.on), *((name, lambda one, name=name: name in one.on) for name in effects)]
    tolerances = sorted({one.tolerance for one in lines})
    yield "relative_tolerance", [(f"{size:g}", lambda one, size=size: one.tolerance == size) for size in tolerances]
    yield "driven", [("record", lambda one: not one.stepped), ("stepped", lambda one: one.stepped)]
    yield "worst output", [(name, lambda one, name=name: one.output == name) for name in ALL]


def report(lines: Sequence[Line], seed: int) -> str:
    """All tables, the worst draws, and what could not be judged."""
    tables = [table(title, lines, groups) for title, groups in _groups(lines)]
    kinds = [("all", lambda one: True), *((kind, lambda one, kind=kind: one.kind == kind) for kind in sorted({one.kind for one in lines}))]
    tables.insert(2, table("friction_force alone", lines, kinds, "friction"))
    return "\n\n".join([*tables, _unjudged(lines), _worst(lines, seed)])


def _unjudged(lines: Sequence[Line]) -> str:
    by_verdict: dict[tuple[str, str], list[int]] = {}
    for one in lines:
        if not is_solved(one):
            by_verdict.setdefault((one.verdict, one.status), []).append(one.number)
    rows = [f"not solved: {sum(map(len, by_verdict.values()))} of {len(lines)}"]
    for (verdict, status), numbers in sorted(by_verdict.items()):
        rows.append(f"  reference: {verdict}; kernel: {status}: {len(numbers)}, draws {', '.join(map(str, numbers[:8]))}")
    return "\n".join([*rows, "", *_ill_conditioned(lines)])


def _ill_conditioned(lines: Sequence[Line]) -> list[str]:
    """Counted apart: each of them, and what the shares would be with them."""
    apart, solved = [one for one in lines if is_solved(one) and not is_judged(one)], [one for one in lines if is_solved(one)]
    moving, several = sum(map(is_ill_conditioned, apart)), sum(map(is_ambiguous, apart))
    rows = [
        f"left out of the tables above, all further off than {FAR} tolerances: {len(apart)} of {len(lines)}; ill-conditioned, as the right "
        f"answer moves by more than {FAR} where inputs or friction levels move by one: {moving}; with more than one slip that solves the "
        f"equations: {several}"
    ]
    for of in ("friction", "any"):
        errors = np.array([getattr(one, of) for one in solved])
        rows.append(f"  {of} with them: {np.mean(errors <= 3):.2%} within 3, {np.mean(errors <= FAR):.2%} within {FAR}")
    for one in sorted(apart, key=lambda one: -one.any):
        rows.append(f"  draw {one.number}: {one.any:.4g}, moves by {one.moves:.4g}, slips {one.slips}; {_what(one)}")
    return rows


def _what(one: Line) -> str:
    driven = "stepped" if one.stepped else "record"
    return f"{one.kind}, {one.law}, {'+'.join(one.on) or 'no effect'}, {one.tolerance:g}, {driven}, {one.steps} steps"


def _worst(lines: Sequence[Line], seed: int, count: int = 20) -> str:
    rows = ["worst draws (python tests/tolerance/campaign.py --seed SEED --draw NUMBER shows one over time)"]
    for one in sorted(filter(is_judged, lines), key=lambda one: -one.any)[:count]:
        rows.append(
            f"  --seed {seed} --draw {one.number:<6}{one.any:>10.4g} tolerances of {one.output}, friction_force "
            f"{one.friction:.4g}; {_what(one)}"
        )
    kernel_seconds, reference_seconds = (sum(getattr(one, name) for one in lines) for name in ("seconds", "reference_seconds"))
    slow = max(lines, key=lambda one: one.seconds)
    rows.append(f"seconds: kernel {kernel_seconds:.1f} (longest {slow.seconds:.3f}, draw {slow.number}), reference {reference_seconds:.1f}")
    rows += [_over_the_median(lines), _beside_the_reference(lines)]
    return "\n".join(rows)


def _over_the_median(lines: Sequence[Line], most: float = 100) -> str:
    """Which draws, refused ones too, take so many times the median time?"""
    median = float(np.median([one.seconds for one in lines]))
    slow = [one for one in sorted(lines, key=lambda one: -one.seconds) if one.seconds > most * median]
    head = f"more than {most:g} times the median of {1e3 * median:.2g} ms: {len(slow)} of {len(lines)}"
    rows = [f"  draw {one.number}: {one.seconds / median:.0f} times, {_what(one)}, {one.status}" for one in slow[:20]]
    return "\n".join([head, *rows])


def _beside_the_reference(lines: Sequence[Line], most: float = 100) -> str:
    """Which draws take so many times more of the reference's time than the median does? A draw is not slow for what happens in it: the
    reference, of order 9 and with steps of its own, has the same ripples, swings and strokes to follow."""
    solved = [one for one in lines if is_solved(one)]
    share = {one.number: one.seconds / max(one.reference_seconds, 1e-6) for one in solved}
    median = float(np.median(list(share.values())))
    slow = [one for one in sorted(solved, key=lambda one: -share[one.number]) if share[one.number] > most * median]
    largest = max(share.values(), default=0.0)
    head = (
        f"time of the kernel over that of the reference: median {median:.2g}, largest {largest:.2g}; more than {most:g} times the median: "
        f"{len(slow)} of {len(solved)}"
    )
    rows = [f"  draw {one.number}: {share[one.number] / median:.0f} times, {_what(one)}" for one in slow[:20]]
    return "\n".join([head, *rows])


def show(judgement: Judgement) -> str:
    """One draw over time."""
    case, names = judgement.case, judgement.names
    parts = [
        f"{case.kind}, effects {', '.join(case.on) or 'none'}, relative_tolerance {case.relative_tolerance:g}, "
        f"{'stepped' if case.motion.stepped else 'record'}",
        "values: " + ", ".join(f"{name} = {value}" for name, value in case.values.items()),
        f"kernel: {judgement.answer.status}, {judgement.answer.steps} steps, {judgement.answer.seconds:.3g} s; reference: "
        f"{judgement.reference.verdict}, {judgement.reference.steps} steps, {judgement.reference.events} events, "
        f"{judgement.reference.seconds:.3g} s",
    ]
    if len(judgement.errors) < 2:
        return "\n".join(parts)
    worst = max((name for name in names if name in ALL), key=lambda name: judgement.worst([name]))
    shown = [name for name in dict.fromkeys(("friction_force", "bristle_deflection", worst)) if name in names]
    inputs = tuple(case.motion.end)
    parts.append("".join(f"{title:>26}" for title in ("time [s]", *inputs, *(f"{n}: kernel, right, error" for n in shown))))
    for row, moment in enumerate(case.motion.times):
        cells = [f"{moment:>26.9g}"] + [
            f"{(case.motion.end[name][row - 1] if row else case.motion.begin[name][0]):>26.9g}" for name in inputs
        ]
        for name in shown:
            place = names.index(name)
            given, right = judgement.answer.rows[row, place], judgement.reference.rows[row, place]
            cells.append(f"{given:>18.9g}{right:>18.9g}{judgement.errors[row, place]:>12.4g}")
        parts.append("".join(cells))
    return "\n".join(parts)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="number of the first draw")
    parser.add_argument("--draw", type=int, help="show this draw over time")
    parser.add_argument("--tight", action="store_true", help="a reference ten times tighter, with steps of half the length")
    arguments = parser.parse_args()
    care = Care(1e-10, 0.5) if arguments.tight else Care()
    if arguments.draw is not None:
        print(show(judge(draw(arguments.seed, arguments.draw), care)))
        return
    begun = time.perf_counter()
    lines = run(arguments.seed, arguments.first, arguments.count, care)
    print(report(lines, arguments.seed))
    print(f"{arguments.count} draws, {time.perf_counter() - begun:.1f} s in all")


if __name__ == "__main__":
    main()
