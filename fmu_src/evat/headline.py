"""What is read first of an answer, on its page and in a terminal?"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, slots=True)
class Headline:
    """`status` is one or two words, `tone` how they look; `first` is said before the `sentence`, `reasons` after it; `share` is the one
    number, of what `share_of` says; `next` is the one thing to do."""

    status: str
    tone: Literal["good", "note", "attention", "bad"]
    sentence: str
    first: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()
    share: str = ""
    share_of: str = ""
    next: str = ""
