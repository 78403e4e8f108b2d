"""Is a run as exact as its relative_tolerance says? A few hundred draws each time, ten thousand as a campaign.

python3 build/test.py -m campaign tests/tolerance
"""

from __future__ import annotations

import numpy as np
import pytest
from campaign import Line, is_judged, report, run
from draws import LAWS
from evat import kernel

SEED = 12


def check(lines: list[Line]) -> None:
    """Error at most 3 tolerances in 99 of 100 draws, and 10 in all; what cannot be judged is rare."""
    judged = [line for line in lines if is_judged(line)]
    errors = np.array([line.any for line in judged])
    worst = max(judged, key=lambda line: line.any)
    again = f"python tests/tolerance/campaign.py --seed {SEED} --draw {worst.number}"
    assert len(judged) >= 0.98 * len(lines)
    assert np.max(errors) <= 10, f"{worst.any:.4g} tolerances of {worst.output}: {again}"
    assert np.mean(errors <= 3) >= 0.99, f"{np.mean(errors > 3):.2%} of the draws are off by more than 3 tolerances"


def test_errors_stay_within_the_tolerance() -> None:
    check(run(SEED, 0, 200))


@pytest.mark.campaign
def test_errors_stay_within_the_tolerance_in_ten_thousand_draws(capsys: pytest.CaptureFixture[str]) -> None:
    lines = run(SEED, 0, 10_000)
    with capsys.disabled():
        print("\n" + report(lines, SEED))
    assert {line.law for line in lines if is_judged(line)} == set(LAWS) == set(kernel.variable("friction_law").choices)
    assert {name for line in lines if is_judged(line) for name in line.on} == {effect.name for effect in kernel.effects()}
    check(lines)
