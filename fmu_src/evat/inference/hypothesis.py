"""What may act beside the nominal model? Effects that are switched on, another base law in place of the nominal one, or nothing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import total_ordering
from typing import Any


@total_ordering
@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A set of `effects` by their names, in the order of the alphabet, and the name of another base `law`, empty where there is none.

    It is a collection of its `names`: its length counts effects and law, and the nominal model alone is empty and false.
    """

    effects: tuple[str, ...] = ()
    law: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "effects", tuple(sorted(set(self.effects))))

    @property
    def names(self) -> tuple[str, ...]:
        """Of effects and law, in the order of the alphabet: as diagnosis.json has the set."""
        return tuple(sorted((*self.effects, self.law))) if self.law else self.effects

    def __len__(self) -> int:
        return len(self.effects) + bool(self.law)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return bool(name) and name in (*self.effects, self.law)

    def __lt__(self, other: Hypothesis) -> bool:
        """By names; where a law and an effect share one, effects first."""
        return (self.names, self.law) < (other.names, other.law)

    def __str__(self) -> str:
        """As a person reads it."""
        return " + ".join(self) or "no effect"

    def beside(self, effect: str) -> Hypothesis:
        """The same with one more effect."""
        return replace(self, effects=(*self.effects, effect))

    def parts(self) -> tuple[Hypothesis, ...]:
        """Each effect and the law alone, in the order of the names."""
        return tuple(Hypothesis(law=name) if name == self.law else Hypothesis((name,)) for name in self)

    def document(self) -> dict[str, Any]:
        """As JSON."""
        return {"effects": list(self.effects), "law": self.law}

    @staticmethod
    def read(held: Mapping[str, Any]) -> Hypothesis:
        """From JSON; KeyError or TypeError where it is none."""
        return Hypothesis(tuple(map(str, held["effects"])), str(held["law"]))


NOMINAL = Hypothesis()
