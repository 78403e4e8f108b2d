"""How is a generation spread over other machines? Its members go to the workers of a dask cluster; a worker that dies loses nothing.

A point's cost does not depend on which worker calculates it, nor on its neighbours there, so the answer is that of one machine.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError
from types import TracebackType
from typing import Any

import numpy as np

from evat.identification.objective import Objective
from evat.model import EvatError, FloatArray

TRIES = 5  # of a generation, while workers die and come back
PATIENCE = 60  # s to wait for a first worker


class ClusterError(EvatError):
    """A cluster that cannot be reached, or has no workers left."""


def _costs(objective: Objective, points: FloatArray) -> FloatArray:
    return objective.costs(points)


class Cluster:
    """A dask cluster, while `with` lasts. Its workers need this package in the same version."""

    def __init__(self, address: str) -> None:
        """address : of the scheduler, as tcp://host:8786."""
        try:
            import distributed
        except ImportError as error:
            raise ClusterError("--dask needs the package distributed, which is not installed here: pip install 'evat[dask]'.") from error
        self._distributed: Any = distributed
        try:
            self._client: Any = self._distributed.Client(address, timeout=10, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ClusterError(f"{address}: no dask scheduler answers there ({error}); start one with `dask scheduler`.") from error
        self._sent: tuple[int, Any] | None = None

    def __enter__(self) -> Cluster:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._client.close()

    def costs(self, objective: Objective, points: FloatArray) -> FloatArray:
        """Costs of a generation, (K, p) -> (K,)."""
        for attempt in range(TRIES):
            try:
                return self._once(objective, points)
            except (CancelledError, self._distributed.client.FutureCancelledError, self._distributed.KilledWorker, OSError) as error:
                self._sent = None  # the workers that held the experiment are gone: send it again
                if attempt == TRIES - 1:
                    raise ClusterError(f"the cluster lost {TRIES} times the workers that had a generation ({error}).") from error
        raise AssertionError("unreachable")

    def each(self, function: Callable[..., Any], shared: Any, points: Sequence[tuple[Any, ...]]) -> Iterator[tuple[int, Any]]:
        """function(shared, *point) for each point, with its number, as they finish; `shared` is sent once."""
        sent = self._client.scatter(shared, broadcast=True, hash=False)
        waiting = {self._client.submit(function, sent, *point, pure=False, retries=TRIES): number for number, point in enumerate(points)}
        try:
            for future, answer in self._distributed.as_completed(waiting, loop=self._client.loop, with_results=True):
                yield waiting[future], answer
        except (CancelledError, self._distributed.client.FutureCancelledError, self._distributed.KilledWorker, OSError) as error:
            raise ClusterError(f"the cluster lost {TRIES} times the worker that had a run ({error}).") from error

    def _once(self, objective: Objective, points: FloatArray) -> FloatArray:
        try:
            self._client.wait_for_workers(1, timeout=PATIENCE)
        except self._distributed.TimeoutError as error:
            raise ClusterError(f"the cluster has had no worker for {PATIENCE} s; start some with `dask worker ADDRESS`.") from error
        if self._sent is None or self._sent[0] != id(objective):
            self._sent = (id(objective), self._client.scatter(objective, broadcast=True, hash=False))
        workers = len(self._client.scheduler_info(n_workers=-1)["workers"])
        pieces = np.array_split(points, min(max(workers, 1), len(points)))
        futures = [self._client.submit(_costs, self._sent[1], piece, pure=False, retries=TRIES) for piece in pieces]
        costs: FloatArray = np.concatenate(self._client.gather(futures))
        return costs
