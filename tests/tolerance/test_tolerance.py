"""Is a run as exact as its relative_tolerance says? A few hundred draws each time, ten thousand as a campaign.

python3 build/test.py -m campaign tests/tolerance
"""

from __future__ import annotations

import numpy as np
import pytest
from campaign import Line, is_ambiguous, is_ill_conditioned, is_judged, line, report, run
from draws import LAWS, draw
from evat.native import kernel

SEED = 12


GIVEN = {"held", "plateau", "ramp", "reversal", "sine", "stop", "stop_and_go", "triangle"}


def check(lines: list[Line], of: str, *, within_3: float = 0.99, within_10: float = 1.0) -> None:
    """Shares of the draws whose error is at most 3 and 10 tolerances; what cannot be judged is rare."""
    judged = [line for line in lines if is_judged(line)]
    errors = np.array([getattr(line, of) for line in judged])
    worst = max(judged, key=lambda line: getattr(line, of))
    again = f"python tests/tolerance/campaign.py --seed {SEED} --draw {worst.number}"
    assert len(judged) >= 0.98 * len(lines)
    beyond = f"of the draws are further off; worst {np.max(errors):.4g} tolerances of {of} force or output {worst.output}: {again}"
    assert np.mean(errors <= 10) >= within_10, f"{np.mean(errors > 10):.2%} {beyond}"
    assert np.mean(errors <= 3) >= within_3, f"{np.mean(errors > 3):.2%} {beyond}"


def test_friction_under_a_given_slip_stays_within_the_tolerance() -> None:
    """Records and communication steps of ramps, stops, reversals and the like, with any law and effect but a holder that gives way, whose
    loop of forces the campaign still finds beyond it."""
    cases = ((number, draw(SEED, number)) for number in range(200))
    chosen = [number for number, case in cases if case.kind in GIVEN and "holder_compliance" not in case.on]
    lines = [line(SEED, number) for number in chosen]
    assert len(lines) > 100
    check(lines, "friction")


@pytest.mark.campaign
def test_errors_stay_within_the_tolerance_in_ten_thousand_draws(capsys: pytest.CaptureFixture[str]) -> None:
    lines = run(SEED, 0, 10_000)
    with capsys.disabled():
        print("\n" + report(lines, SEED))
    assert {line.law for line in lines if is_judged(line)} == set(LAWS) == set(kernel.variable("friction_law").choices)
    assert {name for line in lines if is_judged(line) for name in line.on} == {effect.name for effect in kernel.effects()}
    check(lines, "friction", within_10=0.999)
    check(lines, "any", within_10=0.999)
    assert np.mean([is_ambiguous(line) for line in lines]) < 0.005
    assert np.mean([is_ill_conditioned(line) for line in lines]) < 0.005
