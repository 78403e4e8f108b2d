"""Does a coupled system keep its energy, and does the power balance at the interface say so where it does not?"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from evat.model import ParameterError
from evat.native.kernel import Contact
from evat.studies.coupling import CouplingRun, couple
from evat.systems.coupling import PowerBalance, advise

# A mass on bristles that never yield: elasto-plastic friction far below its break-away is a spring, and nothing takes energy away.
MASS, STIFFNESS = 1.0, 1e6  # kg, N/m
OMEGA = math.sqrt(STIFFNESS / MASS)  # 1000 rad/s
ELASTIC = {
    "kinematics": "external",
    "sigma0": STIFFNESS,
    "sigma1": 0.0,
    "sigma2": 0.0,
    "F_C": 1e6,
    "F_S": 1e6,
    "elasto_plastic.break_away": 0.99,
    "relative_tolerance": 1e-8,
}
SPEED = 0.1  # m/s, to begin with


class MassOnBristles:
    """Mass and contact in turns: the contact with the mass's velocity, held or straight on; the mass with the mean force of the step."""

    def __init__(self, straight: bool) -> None:
        self.contact = Contact(ELASTIC, ("elasto_plastic",))
        self.contact.start()
        self.straight, self.time, self.velocity, self.rate = straight, 0.0, SPEED, 0.0

    def energy(self) -> float:
        z = self.contact.get("bristle_deflection")
        return 0.5 * MASS * self.velocity**2 + 0.5 * STIFFNESS * z**2

    def step(self, step: float) -> PowerBalance:
        told = np.array([self.velocity, self.velocity + (self.rate * step if self.straight else 0.0)])
        before = self.contact.get("friction_impulse")
        times = np.array([self.time, self.time + step])
        after = self.contact.run(times, {"slip_velocity": told}, ("friction_impulse",))[-1, 0]
        force = -(after - before) / step  # on the mass
        self.rate = force / MASS
        velocity, self.velocity = self.velocity, self.velocity + step * self.rate
        self.time += step
        return PowerBalance(force, float(told.mean()), force, 0.5 * (velocity + self.velocity))


def growth(straight: bool, step: float, end: float = 0.02) -> tuple[float, float]:
    """Energy gained, and what the power balance says was made, as shares of what there was."""
    system = MassOnBristles(straight)
    begun, made = system.energy(), 0.0
    for _ in range(round(end / step)):
        made += system.step(step).residual(step)
    return (system.energy() - begun) / begun, made / begun


def test_held_inputs_make_energy_as_the_exact_answer_says() -> None:
    """One step is a linear map with determinant 1 + (w H)^2/2, which is the growth of the energy of a free oscillation."""
    for step in (1e-4, 5e-5, 2.5e-5):
        expected = (1 + 0.5 * (OMEGA * step) ** 2) ** (0.02 / step) - 1
        gained, _ = growth(False, step)
        # the energy wavers within an oscillation by the order of w H
        assert gained == pytest.approx(expected, abs=OMEGA * step * (1 + expected))


def test_straight_inputs_make_far_less() -> None:
    """Held: the energy error is of first order in the step. Straight: of second order at least."""
    held, straight = ([abs(growth(kind, step)[0]) for step in (1e-4, 5e-5, 2.5e-5)] for kind in (False, True))
    assert held[0] / held[1] > 1.7
    assert held[1] / held[2] > 1.7
    assert straight[0] / straight[1] > 3.4
    assert straight[1] / straight[2] > 3.4
    assert straight[2] < 0.1 * held[2]


@pytest.mark.parametrize("straight", [False, True])
def test_the_power_balance_knows_what_was_made(straight: bool) -> None:
    """Where nothing takes energy away, what the interface makes is what the system gains."""
    for step in (1e-4, 2.5e-5):
        gained, made = growth(straight, step)
        assert made == pytest.approx(gained, rel=0.2 if straight else 1e-6)  # means leave out how force and velocity go together in a step
        assert abs(gained) > 1e-5


def controlled(tolerance: float) -> tuple[int, float]:
    system, made, steps = MassOnBristles(True), 0.0, 0
    step, error = 1e-6, 1.0
    while system.time < 0.02:
        bond = system.step(step)
        made += abs(bond.residual(step))
        advice = advise(step, [bond], stored=0.5 * MASS * SPEED**2, tolerance=tolerance, order=1, error_before=error, longest=1e-3)
        step, error, steps = advice.next_step, max(advice.error, 1e-6), steps + 1
    return steps, made / (0.5 * MASS * SPEED**2)


def test_the_advice_keeps_each_step_within_the_tolerance() -> None:
    """A thousandth of the tolerance, a tenth of the step: the residual of straight inputs grows with its third power."""
    (few, much), (many, little) = controlled(1e-3), controlled(1e-6)
    assert many / few == pytest.approx(10, rel=0.3)
    assert 0.1 < much / (few * 1e-3) < 1.1
    assert 0.1 < little / (many * 1e-6) < 1.1


def test_a_step_that_makes_too_much_is_not_accepted() -> None:
    bond = PowerBalance(force=10.0, velocity=0.1, other_force=10.0, other_velocity=0.12)
    good = advise(1e-3, [bond], stored=1.0, tolerance=1e-3)
    bad = advise(1e-3, [bond], stored=1e-3, tolerance=1e-3)
    assert good.residual == bad.residual == pytest.approx(2e-4)
    assert (good.accept, bad.accept) == (True, False)
    assert bad.next_step < 1e-3 < good.next_step
    held = advise(1e-3, [bond], stored=1e-3, tolerance=0.05, order=0)  # falls with a lower power of the step, so it must shrink further
    assert held.next_step < advise(1e-3, [bond], stored=1e-3, tolerance=0.05, order=1).next_step < 1e-3
    still = advise(1e-3, [PowerBalance(0.0, 0.0, 0.0, 0.0)], stored=0.0)
    assert still.accept
    assert still.next_step == 2e-3
    opposite = PowerBalance(force=10.0, velocity=0.12, other_force=10.0, other_velocity=0.1)
    assert advise(1e-3, [bond, opposite], stored=1e-3).error > bad.error
    with pytest.raises(ParameterError, match="step"):
        advise(0.0, [bond], stored=1.0)
    with pytest.raises(ParameterError, match="finite"):
        advise(1e-3, [PowerBalance(math.nan, 1.0, 1.0, 1.0)], stored=1.0)


# ---- the cut on a compliant tool --------------------------------------------------------------------------------------------------------

END, VALUES = 0.02, {"cutting_speed": 0.3, "feed": 2e-5}


@pytest.fixture(scope="module")
def error() -> Callable[[CouplingRun], float]:
    """Of a run's displacement against steps of 4 us, a twelfth of a vibration cycle, as a share of the largest."""
    fine = couple(4e-6, END, values=VALUES)

    def error(run: CouplingRun) -> float:
        every = round((run.times[1] - run.times[0]) / 4e-6)
        return float(np.abs(run.displacement - fine.displacement[::every]).max() / np.abs(fine.displacement).max())

    return error


def test_straight_inputs_are_of_second_order_and_held_ones_of_first(error: Callable[[CouplingRun], float]) -> None:
    held = [error(couple(step, END, inputs="held", values=VALUES)) for step in (2e-3, 1e-3, 5e-4)]
    straight = [error(couple(step, END, values=VALUES)) for step in (2e-3, 1e-3, 5e-4)]
    assert np.log2(held[0] / held[2]) / 2 == pytest.approx(1, abs=0.3)
    assert np.log2(straight[0] / straight[2]) / 2 == pytest.approx(2, abs=0.4)
    assert straight[1] < 0.01 < held[1]


def test_the_averaged_contact_moves_the_tool_alike(error: Callable[[CouplingRun], float]) -> None:
    """A hundredth of the displacement at 1 ms, where a tool of 200 Hz has five steps in an oscillation; what the vibration's own phase at
    the start does, half a cycle of 400, stays at short steps."""
    assert error(couple(1e-3, END, averaging="cycle", values=VALUES)) < 0.01
    assert error(couple(5e-4, END, averaging="cycle", values=VALUES)) < 0.006


def test_a_force_that_is_sampled_from_a_vibration_says_nothing(error: Callable[[CouplingRun], float]) -> None:
    """The force of an instant, held over whole cycles: more than half of the displacement is wrong. Its mean is what a machine needs."""
    assert error(couple(1e-4, END, inputs="held", force="instant", values=VALUES)) > 0.5


def test_the_interface_makes_less_energy_with_straight_inputs() -> None:
    """Over 20 ms at 0.5 ms, against what the tool holds at most; from the second step on, as the first does not know its acceleration."""
    for averaging in ("resolved", "cycle"):
        held, straight = (couple(5e-4, END, averaging=averaging, inputs=inputs, values=VALUES) for inputs in ("held", "straight"))  # type: ignore[arg-type]
        of_held, of_straight = (abs(run.made[-1] - run.made[1]) for run in (held, straight))
        assert of_straight < 0.4 * of_held
        assert of_straight < 0.02 * straight.stored.max()
