"""How many points does each stretch of a long recording get? What repeats itself the most, spread over the whole record."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from evat.experiment.compression.overview import Overview
from evat.experiment.compression.pieces import FINE, Piece
from evat.experiment.compression.stretches import Stretch, plain
from evat.model import FloatArray

PARTS = 12  # average cycles over a record, where it repeats itself throughout
CYCLES = 4  # of an average at least: one for each of its quarters
PER_PART = 8  # averages in time of what is held, in place of an average cycle
PASSING = 0.25  # of all points, for transients beside what stands still
MOST_OF_VIBRATION = 1000  # points of a vibration cycle: chip and tool part within a hundredth of it
ROWS_OF_POINT = 50  # rows that are averaged to one of these at least
FEWEST = 24  # points of a cycle, and of a transient
LEADING, LEADING_REST = 200, 1000  # points before a transient, and before what is held: how it came to rest stays in its bristles
MOSTLY, TOGETHER = 0.98, 8  # share of a transient, told by so many neighbours at a time, in which
MISSED = 0.005  # of the standard deviation of a column: so much may thinning take away, else pieces are left out


def pieces_of(course: list[Stretch], samples: int, overview: Overview | None) -> list[tuple[Piece, Piece | None]]:
    """Each piece with the one that leads in, where rows do. overview : None of a vibration."""
    repeating = [each for each in course if each.kind == "repeating" and each.cycles >= CYCLES]
    held = [each for each in course if each.kind == "held"]
    passing = [each for each in course if each.kind == "transient" or (each.kind == "repeating" and each.cycles < CYCLES)]
    length = {kind: sum(each.end - each.begin for each in some) for kind, some in (("stands", repeating + held), ("passes", passing))}
    # Of a vibration that sets in, ends or leaps nothing recorded says why, and no model follows it.
    for_passing = 0 if not length["passes"] or overview is None else samples if not length["stands"] else int(PASSING * samples)
    still = [(each, _parts(each, length["stands"])) for each in held]
    pieces = [(_still(each, PER_PART * parts), _before(each, course)) for each, parts in still]
    left = samples - for_passing - sum(piece.points for piece, _ in pieces)
    parts = [min(_parts(each, length["stands"], 2), each.cycles // CYCLES) for each in repeating]
    points = max(left // max(sum(parts), 1), FEWEST)
    for each, count in zip(repeating, parts, strict=True):
        pieces += [(piece, None) for piece in _average_cycles(each, count, points, overview is None)]
    return pieces + (_transients(passing, for_passing, overview) if for_passing and overview is not None else [])


def _parts(stretch: Stretch, rows: int, least: int = 1) -> int:
    return max(round(PARTS * (stretch.end - stretch.begin) / rows), least)


def _still(stretch: Stretch, points: int) -> Piece:
    rows = stretch.end - stretch.begin
    points = max(min(points, rows // 16), min(3, rows))
    return Piece(stretch, stretch.begin, stretch.end, points, 1, 2 if rows >= 16 * points else 1)


def _before(stretch: Stretch, course: list[Stretch]) -> Piece | None:
    """What led into a held stretch: the transient before it, from as long before."""
    last = next((each for each in course if each.end == stretch.begin), None)
    if last is None:
        return None
    begin = last.begin - (last.end - last.begin) if last.kind == "transient" else last.end - (stretch.end - stretch.begin) // LEADING
    begin = max(begin, 0)
    points = min(LEADING_REST, last.end - begin)
    return Piece(plain("transient", begin, last.end), begin, last.end, points, 1, 1)


def _average_cycles(stretch: Stretch, count: int, points: int, vibrates: bool) -> list[Piece]:
    first, last = np.ceil(stretch.phases[0]), np.floor(stretch.phases[-1])
    edges = np.interp(np.round(np.linspace(first, last, count + 1)), stretch.phases, stretch.rows)
    rows_of_cycle = (edges[-1] - edges[0]) / (last - first)
    if vibrates:
        points, fine = min(points, MOST_OF_VIBRATION, max(int((edges[1] - edges[0]) / ROWS_OF_POINT), 1)), 1
    else:
        points = min(points, int(rows_of_cycle))
        fine = _odd(rows_of_cycle / points)
    rows = [int(np.ceil(edge)) for edge in edges]
    return [Piece(stretch, begin, end, points, fine, 2) for begin, end in pairwise(rows)]


def _transients(passing: list[Stretch], points: int, overview: Overview) -> list[tuple[Piece, Piece | None]]:
    rows = sum(each.end - each.begin for each in passing)
    step = max(rows / points, 1.0)
    coarsest = _coarsest(overview, passing)
    pieces = list[tuple[Piece, Piece | None]]()
    for each in passing:
        own = int(points * (each.end - each.begin) / rows)
        if step <= coarsest:
            windows = [(each.begin, each.end)]
        else:  # windows, evenly over it, of rows as dense as they must be
            size = int(min(max(own, FEWEST), 8 * FEWEST) * coarsest)
            count = max(int(own * coarsest / size), 1)
            starts = np.linspace(each.begin, max(each.end - size, each.begin), count) if count > 1 else [each.begin]
            windows = [(int(start), min(int(start) + size, each.end)) for start in starts] if own >= FEWEST else []
        density = min(step, coarsest)
        for begin, end in windows:
            wanted = int((end - begin) / density)
            if wanted < FEWEST:
                continue
            lead = max(begin - int(LEADING * density), 0)
            before = int((begin - lead) / density)
            fine = _odd(density)
            pieces.append(
                (
                    Piece(plain("transient", begin, end), begin, end, wanted, fine, 1),
                    Piece(plain("transient", lead, begin), lead, begin, before, fine, 1) if before >= 3 else None,
                )
            )
    return pieces


def _coarsest(overview: Overview, passing: list[Stretch]) -> float:
    """Rows apart that points may be without a straight line between them missing more than MISSED of any column, or its noise, but in a few
    places such as jumps."""
    pieces = [overview.means[each.begin // overview.block : each.end // overview.block, 1:] for each in passing]
    spread, step = overview.means[:, 1:].std(axis=0) + 1e-300, 1
    noise = 1.4826 * np.median(np.abs(np.concatenate([np.diff(piece, 2, axis=0) for piece in pieces])), axis=0) / np.sqrt(6)
    while True:
        seen = list[FloatArray]()
        for piece in pieces:
            second = np.diff(_thinned(piece, 2 * step), 2, axis=0)
            products = second[3:] * second[:-3]  # noise has no part in products of those that share no point
            if len(products) >= TOGETHER:
                seen.append(np.abs(_thinned(products, TOGETHER)))
        if not seen or len(merged := np.concatenate(seen)) < FEWEST:
            return float(step * overview.block)
        missed = np.sqrt(np.quantile(merged, MOSTLY, axis=0)) / 8
        if np.any(missed > np.maximum(MISSED * spread, noise / np.sqrt(2 * step))):
            return float(step * overview.block)
        step *= 2


def _thinned(piece: FloatArray, by: int) -> FloatArray:
    whole = piece[: len(piece) // by * by]
    means: FloatArray = whole.reshape(-1, by, piece.shape[1]).mean(axis=1)
    return means


def _odd(ratio: float) -> int:
    """Fine bins of a point where it has so many rows."""
    return min(FINE, (int(ratio) - 1) // 2 * 2 + 1) if ratio >= 3 else 1
