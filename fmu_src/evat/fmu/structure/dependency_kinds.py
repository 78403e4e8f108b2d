"""With which factor does each known enter each unknown, and how long does the factor stay the same?"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from evat.model import FloatArray

Mask = npt.NDArray[np.bool_]
KINDS = ("constant", "fixed", "tunable")  # with which factor a known enters linearly; else "dependent"


class Factors:
    """What changes of the knowns have shown so far."""

    def __init__(self, unknowns: int, knowns: int) -> None:
        self.seen = np.zeros((unknowns, knowns), dtype=bool)
        self.same = np.ones((len(KINDS), unknowns, knowns), dtype=bool)
        self.factor = np.full((len(KINDS), unknowns, knowns), np.nan)

    @property
    def settled(self) -> Mask:
        """Pairs of which a further change can tell nothing."""
        return self.seen & ~self.same.any(axis=0)

    def forget(self, kind: str) -> None:
        """Parameters have changed on which factors of this kind may depend."""
        self.factor[KINDS.index(kind)] = np.nan

    def add(self, changes: FloatArray, moves: FloatArray, size: FloatArray, told: Mask) -> None:
        """Take note of one operating point.

        Parameters
        ----------
        changes : of every unknown before and after an event, for every known that was moved, shape (2, unknowns, knowns).
        moves : by which each known was moved, shape (knowns,).
        size : of the unknowns, shape (unknowns,).
        told : the pairs of which this tells something, shape (unknowns, knowns).
        """
        self.seen |= told & np.any(changes != 0, axis=0)
        with np.errstate(over="ignore", invalid="ignore"):  # a move may be as small as numbers get
            factor, after = changes / moves
            blur = 1e-9 * np.abs(factor) + 1e-14 * size[:, None] / np.abs(moves)
            same = np.abs(after - factor) <= blur
        first = told & np.isnan(self.factor)
        self.same &= ~told | (same & (first | (np.abs(self.factor - factor) <= blur)))
        np.copyto(self.factor, factor, where=first)

    def kind(self, unknown: int, known: int) -> str:
        """FMI's dependenciesKind of a pair."""
        return next((kind for place, kind in enumerate(KINDS) if self.same[place, unknown, known]), "dependent")
