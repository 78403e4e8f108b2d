"""Is a search on a cluster the same as here, even if one of its workers is killed on the way?"""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from evat.identification import Execution, Settings, identify
from evat.identification.objective import Objective
from evat.identification.searching.cluster import Cluster, ClusterError
from evat.models.contact import ContactModel
from known_rigs import FREE, TO_AND_FRO, experiment, trial

distributed = pytest.importorskip("distributed")
RIG = experiment(trial(TO_AND_FRO))
SETTINGS = {"population": 32, "generations": 15, "seed": 3, "profiles": False}


@pytest.fixture(scope="module")
def local() -> Iterator[Any]:
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        yield cluster


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_nothing(local: Any) -> None:
    """Of two processes one is killed after some generations; the result is that of this process, to the last bit."""
    model, generations, killed = ContactModel(threads=1), [0], []
    alone = identify(RIG, model, FREE, Settings(search="de", **SETTINGS))  # type: ignore[arg-type]
    with Cluster(local.scheduler_address) as cluster:

        def spread(objective: Objective, points: np.ndarray) -> np.ndarray:
            generations[0] += 1
            if generations[0] == 5:
                victim = next(iter(local.workers.values())).pid
                os.kill(victim, signal.SIGKILL)
                killed.append(victim)
            return cluster.costs(objective, points)

        identification = identify(RIG, model, FREE, Settings(search="de", **SETTINGS), execution=Execution(spread=spread))  # type: ignore[arg-type]
    assert killed
    assert generations[0] == len(identification.history)
    assert [e.value for e in identification.estimates] == [e.value for e in alone.estimates]
    assert identification.history == alone.history


def test_no_scheduler_is_an_error() -> None:
    with pytest.raises(ClusterError, match=r"no dask scheduler answers there"):
        Cluster("tcp://127.0.0.1:9")
