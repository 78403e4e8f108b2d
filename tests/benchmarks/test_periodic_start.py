"""For how many cycles does the search for a periodic start take, where effects have states of their own?"""

from __future__ import annotations

import time
from typing import Any

import pytest
from evat.native.kernel import Contact
from report import Summary
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="periodic start")

CYCLES = 40
PERIOD = 5e-5  # s, at the start values


@pytest.mark.parametrize(
    ("effect", "slopes"),
    [("amplitude_loss", 2), ("dynamometer_resonance", 1), ("holder_compliance", 5), ("maxwell_slip", 0), ("sensor_lowpass", 1)],
)
def test_with_states_of_an_effect(benchmark: Any, summary: Summary, effect: str, slopes: int) -> None:
    """Limit: a cycle that tells what comes back, one for each state whose slopes nobody knows, and one from the state that is sought."""

    def contact(start: str) -> Contact:
        begun = Contact({"initial_state": start}, (effect,))
        begun.start()
        return begun

    running = contact("periodic")

    def pass_cycles() -> None:
        for _ in range(CYCLES // 4):
            running.advance(4 * PERIOD)  # so few that none is skipped

    seconds = least({"at_rest": lambda: contact("at_rest"), "periodic": lambda: contact("periodic"), "cycles": pass_cycles})
    benchmark.pedantic(lambda: contact("periodic"), rounds=1)
    cycles = (seconds["periodic"] - seconds["at_rest"]) / seconds["cycles"] * CYCLES
    summary.add(f"periodic start with {effect}", f"{cycles:.0f} cycles", limit=f"{2 + slopes}")
    assert cycles < 16
