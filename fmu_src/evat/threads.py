"""How is work shared out to threads? To such as are kept from call to call: each takes as long to start as a thousand samples to run."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from functools import cache


def kept_threads(purpose: str, count: int) -> ThreadPoolExecutor:
    """So many threads for one purpose. Work of one purpose must not wait for other work of the same."""
    return _threads(os.getpid(), purpose, count)


@cache
def _threads(process: int, purpose: str, count: int) -> ThreadPoolExecutor:
    """process : one that was forked has none of its parent's."""
    return ThreadPoolExecutor(count, f"{purpose}-{process}")
