"""What would a computation give if a constant had another value? The process forks where the constant is first read, and both go on.

What came before that needs no second run: a constant that is read late costs little, one that is never read nothing.
"""

from __future__ import annotations

import gc
import json
import os
import sys
import traceback
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from typing import Any

from evat.constants import CONSTANTS, Value
from evat.model import EvatError

Answer = dict[str, Any]


def can_fork() -> bool:
    """Windows cannot."""
    return hasattr(os, "fork")


def with_forks(work: Callable[[], Answer], values: Mapping[str, Sequence[Value]], tell: Callable[[str, int, Answer], None]) -> Answer:
    """What `work` gives as it is; and by `tell` what it gives with each of these values of a constant, where that is read: name, place of
    the value, answer. Answers are what JSON can hold. The process should have one thread; one child runs at a time."""
    forks = _Forks(values, tell)
    try:
        with CONSTANTS.told_before_reading(forks.before_reading):
            answer = work()
        if forks.pipe is not None:
            with open(forks.pipe, "w", encoding="utf-8") as pipe:
                json.dump(answer, pipe)
            os._exit(0)
    except BaseException:
        if forks.pipe is not None:  # a child must not come back to where its parent goes on
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(1)
        raise
    return answer


class _Forks:
    """`pipe` is where a child leaves its answer; None in the parent."""

    def __init__(self, values: Mapping[str, Sequence[Value]], tell: Callable[[str, int, Answer], None]) -> None:
        self.left, self.tell, self.kept = dict(values), tell, ExitStack()
        self.pipe: int | None = None

    def before_reading(self, name: str) -> None:
        if self.pipe is not None:
            return
        for place, value in enumerate(self.left.pop(name, ())):
            answer = self._of_a_child(name, value)
            if answer is None:
                return
            self.tell(name, place, answer)

    def _of_a_child(self, name: str, value: Value) -> Answer | None:
        """None in the child, which goes on with the value."""
        reads, writes = os.pipe()
        sys.stdout.flush()
        sys.stderr.flush()
        child = os.fork()
        if child == 0:
            os.close(reads)
            gc.freeze()  # what both share stays shared
            self.pipe = writes
            self.kept.enter_context(CONSTANTS.replaced(**{name: value}))
            return None
        os.close(writes)
        with open(reads, encoding="utf-8") as pipe:
            text = pipe.read()
        _, status = os.waitpid(child, 0)
        if status or not text:
            raise EvatError(f"{name} = {value}: the process that went on with it ended with status {status} and without an answer.")
        answer: Answer = json.loads(text)
        return answer
