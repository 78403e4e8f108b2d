"""A pytest plugin: in which order do tests find a mistake soonest? Those that found most in least time go first.

Reads and writes the JSON file that MUTATION_ORDER names: test -> [seconds, mistakes found]. A test that takes far longer than it did on the
code without a mistake is ended with its process, by the alarm of the system: an endless loop is found too.
"""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

ORDER = Path(os.environ["MUTATION_ORDER"])
LONGEST = float(os.environ.get("MUTATION_LONGEST", "inf"))  # [s] on the code without a mistake; longer tests are left out
KNOWN: dict[str, list[float]] = json.loads(ORDER.read_text(encoding="utf-8")) if ORDER.is_file() else {}
MEASURES = not KNOWN  # the first run, on the code without a mistake, measures
SETUP: dict[str, float] = {}  # of a module: its fixtures are made again where its tests do not follow each other
MEASURED: dict[str, list[float]] = {}


UNKNOWN = [0.1, 0.0]  # a test that came later


def _promise(test: str) -> float:
    seconds, kills = KNOWN.get(test, UNKNOWN)
    return (kills + 0.1) / (seconds + 0.05)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if MEASURES:
        return
    kept = [item for item in items if KNOWN.get(item.nodeid, UNKNOWN)[0] <= max(LONGEST, UNKNOWN[0])]
    config.hook.pytest_deselected(items=[item for item in items if item not in kept])
    items[:] = sorted(kept, key=lambda item: -_promise(item.nodeid))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    if not MEASURES:
        print(f"\n@ {item.nodeid}", flush=True)  # the last such line of a process that was ended says in which test
        signal.setitimer(signal.ITIMER_REAL, 15 + 8 * KNOWN.get(item.nodeid, UNKNOWN)[0])
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    module = report.nodeid.partition("::")[0]
    if report.when == "setup":
        SETUP[module] = max(SETUP.get(module, 0.0), report.duration)
    elif report.when == "call" and report.passed:
        MEASURED[report.nodeid] = [report.duration, 0]


def pytest_sessionfinish() -> None:
    if MEASURES:
        told = {test: [seconds + SETUP[test.partition("::")[0]], kills] for test, (seconds, kills) in MEASURED.items()}
        ORDER.write_text(json.dumps(told, indent=0), encoding="utf-8")
