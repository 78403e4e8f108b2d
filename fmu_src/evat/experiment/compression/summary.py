"""What was done with a long recording, in plain words?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from evat.experiment.compression.pieces import Piece
from evat.experiment.compression.stretches import Stretch
from evat.model import FloatArray


@dataclass(frozen=True)
class CompressionSummary:
    """Of one recording: `rows` over `seconds` became `samples`, repeats counted once. `left_out` are seconds of transients that did not
    fit; `averaged_out` (by output) is the root mean square of what averages left out of the rows, noise and all, and its share of all."""

    file: str
    rows: int
    seconds: float
    samples: int
    cycles: int
    averages: int
    points: int
    held: int
    held_seconds: float
    transients: int
    transient_seconds: float
    transient_step: float
    left_out: float
    averaged_out: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        file: str,
        rows: int,
        seconds: float,
        course: Sequence[Stretch],
        pieces: Sequence[tuple[Piece, Piece | None]],
        names: Sequence[str],
        outputs: Sequence[str],
        clock: Callable[[FloatArray], FloatArray],
    ) -> CompressionSummary:
        some = [piece for piece, _ in pieces]
        by_kind = {kind: [piece for piece in some if piece.stretch.kind == kind] for kind in ("repeating", "held", "transient")}
        lasting = {kind: sum(_seconds(piece, clock) for piece in own) for kind, own in by_kind.items()}
        transients = [each for each in course if each.kind == "transient"]
        whole = sum(_seconds(each, clock) for each in transients)
        steps = [_seconds(piece, clock) / piece.points for piece in by_kind["transient"]]
        left = [np.array([*piece.left_out(*piece.averages())]) for piece in by_kind["repeating"] + by_kind["held"]]
        size = [piece.squares / piece.counts.sum() for piece in by_kind["repeating"] + by_kind["held"]]
        averaged_out = {}
        for name in outputs if left else ():
            place = names.index(name)
            rms = float(np.sqrt(np.mean([row[place] ** 2 for row in left])))
            averaged_out[name] = (rms, rms / max(float(np.sqrt(np.mean([row[place] for row in size]))), 1e-300))
        return cls(
            file=file,
            rows=rows,
            seconds=seconds,
            samples=sum(len(piece.averages()[0]) for piece in some),
            cycles=sum(round(piece.phases[1] - piece.phases[0]) for piece in by_kind["repeating"]),
            averages=len(by_kind["repeating"]),
            points=max((len(piece.averages()[0]) for piece in by_kind["repeating"]), default=0),
            held=len(by_kind["held"]),
            held_seconds=lasting["held"],
            transients=len(by_kind["transient"]),
            transient_seconds=lasting["transient"],
            transient_step=float(np.median(steps)) if steps else 0.0,
            left_out=max(whole - lasting["transient"], 0.0),
            averaged_out=averaged_out,
        )

    def __str__(self) -> str:
        done = []
        if self.averages:
            done.append(f"{_count(self.cycles)} cycles averaged into {self.averages} of up to {self.points} points")
        if self.held:
            done.append(f"{_several(self.held, 'stretch', 'es')} held still ({self.held_seconds:.4g} s) averaged")
        if self.transients:
            done.append(
                f"{_several(self.transients, 'transient', 's')} ({self.transient_seconds:.3g} s) kept, every {self.transient_step:.3g} s"
            )
        if self.left_out > 1e-3 * self.seconds:
            done.append(f"{self.left_out:.3g} s left out that neither repeats itself nor stands still")
        averaged = "; ".join(f"{name} {rms:.3g} rms, {share:.2%} of its own" for name, (rms, share) in self.averaged_out.items())
        rest = f"; the averages leave out, noise and all: {averaged}" if averaged else ""
        return f"{self.file}: {self.seconds:.4g} s, {_count(self.rows)} rows became {_count(self.samples)} samples: {', '.join(done)}{rest}"


def _seconds(each: Piece | Stretch, clock: Callable[[FloatArray], FloatArray]) -> float:
    begin, end = clock(np.array([float(each.begin), float(each.end)]))
    return float(end - begin)


def _several(count: int, what: str, ending: str) -> str:
    return f"{count} {what}{ending * (count != 1)}"


def _count(number: int) -> str:
    return f"{number:,}".replace(",", " ")
