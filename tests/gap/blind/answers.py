"""What does a diagnosis.json say? Read as a stranger would: by the documented format, nothing assumed of who wrote it."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

VERDICTS = ("no_gap", "mistuned", "effect", "ambiguous", "unknown", "cannot_tell")
LIKELY = 0.9
Names = frozenset[str]


@dataclass(frozen=True)
class Answer:
    """failed: why there is none, else empty. candidates: sets with their probabilities, the likeliest first. likely: the sets that hold
    90 % of it, and what the diagnosis could not tell from them."""

    failed: str = ""
    verdict: str = ""
    candidates: tuple[tuple[Names, float], ...] = ()
    likely: tuple[Names, ...] = ()
    novelty: float = 0.0
    regions: tuple[dict[str, Any], ...] = ()
    closure: float | None = None
    gap: dict[str, dict[str, float]] = field(default_factory=dict)
    seconds: float | None = None
    given: Names = frozenset()

    @property
    def top(self) -> Names:
        """The effects that the verdict names: those listed, or of several sets the likeliest; none for any other verdict."""
        if self.verdict not in ("effect", "ambiguous"):
            return frozenset()
        if self.verdict == "effect" and self.given:
            return self.given
        return self.first_effects

    @property
    def names(self) -> bool:
        return bool(self.top)

    @property
    def first_effects(self) -> Names:
        """The likeliest set that is not empty."""
        return next((s for s, _ in self.candidates if s), self.given)

    @property
    def confidence(self) -> float | None:
        """The probability of what the verdict stands for; None where it says that it cannot tell."""
        if self.failed or self.verdict in ("unknown", "cannot_tell"):
            return None
        return next((p for s, p in self.candidates if s == self.top), None)

    def gap_ratio(self, label: dict[str, Any]) -> float | None:
        """Structural gap after recalibration as reported, over the true one, in the channel where that is largest against its noise."""
        channel, told = self._told(label)
        return math.sqrt(max(told["recalibrated"] ** 2 - told["noise_floor"] ** 2, 0.0)) / label["gap_rms"][channel] if told else None

    def closed(self, label: dict[str, Any]) -> float | None:
        """Share closed on held-out conditions over what one who knows the truth could have closed, by the same noise floor."""
        channel, told = self._told(label)
        if self.closure is None or not told:
            return self.closure
        open_before = told["recalibrated"] ** 2 - told["noise_floor"] ** 2
        possible = (told["recalibrated"] ** 2 - label["oracle_rms"][channel] ** 2) / open_before if open_before > 0 else 1.0
        return min(self.closure / min(max(possible, 0.2), 1.0), 1.0)

    def _told(self, label: dict[str, Any]) -> tuple[str, dict[str, float]]:
        channel = max(label["gap_over_noise"], key=lambda name: label["gap_over_noise"][name])
        told = self.gap.get(channel) or {}
        return channel, told if {"recalibrated", "noise_floor"} <= set(told) else {}


def read_answer(path: Path) -> Answer:
    """The answer in that file; one that failed where there is none, or where it breaks the format."""
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
        return _answer(document)
    except FileNotFoundError:
        return Answer(failed="no diagnosis.json")
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        return Answer(failed=f"diagnosis.json: {type(error).__name__}: {error}")


def _answer(document: dict[str, Any]) -> Answer:
    if document["format"] != 1 or document["verdict"] not in VERDICTS:
        raise ValueError(f"format {document['format']!r}, verdict {document['verdict']!r}")
    effects = document.get("effects") or []
    given = frozenset(str(e["name"]) for e in effects)
    candidates = [(frozenset(map(str, c["set"])), float(c["probability"])) for c in document.get("candidates") or []]
    if not candidates and given:
        candidates = [(given, min(float(e.get("probability", 1.0)) for e in effects))]
    candidates.sort(key=lambda one: (-one[1], sorted(one[0])))
    if any(not 0 <= p <= 1.000001 for _, p in candidates):
        raise ValueError("a probability outside 0..1")
    like = {str(e["name"]): [str(n) for n in e.get("not_separable_from") or []] for e in effects}
    closed = (document.get("gap") or {}).get("closed_share") or {}
    p_value = (document.get("novelty") or {}).get("p_value")
    return Answer(
        verdict=document["verdict"], candidates=tuple(candidates), likely=_likely(candidates, given, like),
        novelty=-float(p_value) if p_value is not None else -0.5, regions=tuple((document.get("where") or {}).get("regions") or ()),
        closure=float(closed["value"]) if closed.get("value") is not None else None,
        gap={channel: _numbers(told) for channel, told in ((document.get("gap") or {}).get("channels") or {}).items()},
        seconds=(document.get("made_by") or {}).get("seconds"), given=given,
    )  # fmt: skip


def _likely(candidates: list[tuple[Names, float]], given: Names, like: dict[str, list[str]]) -> tuple[Names, ...]:
    likely: list[Names] = []
    held = 0.0
    for names, probability in candidates:
        if held >= LIKELY or probability <= 0:
            break
        likely.append(names)
        held += probability
    if not likely and given:
        likely.append(given)
    for name, others in like.items():
        for other in others:
            swapped = given - {name} | {other}
            if swapped not in likely:
                likely.append(swapped)
    return tuple(likely)


def _numbers(told: dict[str, Any]) -> dict[str, float]:
    return {name: float(x) for name, x in told.items() if isinstance(x, (int, float))}
