"""How is one thing timed against another on a machine that others use too? Processor time, taken in turns, the least of each."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

Action = Callable[[], object]
SHORTEST = 0.01  # s; a shorter action is repeated until it fills this, lest it be timed with the cold caches that the one before it left


def least(actions: Mapping[str, Action], rounds: int = 7) -> dict[str, float]:
    """Least processor seconds of one run of each action. Every round runs all of them, so that none gets the quiet hour for itself."""
    fastest, repeats = dict.fromkeys(actions, math.inf), dict.fromkeys(actions, 1)
    for _ in range(rounds):
        for name, action in actions.items():
            begin = time.process_time()
            for _ in range(repeats[name]):
                action()
            once = (time.process_time() - begin) / repeats[name]
            fastest[name] = min(fastest[name], once)
            repeats[name] = max(repeats[name], math.ceil(SHORTEST / max(once, 1e-7)))
    return fastest
