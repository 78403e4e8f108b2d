"""Does a host that puts a mass, a spring or a servo around the FMU find what LuGre showed in 1995? Both interfaces of both versions.

In model exchange the bristle is one of the states that Radau integrates. In co-simulation the plant goes on by the trapezoidal rule and
the FMU by its own steps, both over the same communication step, which is repeated from a saved FMU state until they agree.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import fmpy
import lugre_1995 as published
import numpy as np
import pytest
from evat import parameter_sets
from evat.native.kernel import by_choice
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from lugre_1995 import Motion, Plant

VALUES = {**by_choice(parameter_sets.load("lugre-1995").values), **published.DRIVEN_FROM_OUTSIDE, "relative_tolerance": 1e-7}
PASSES = 4  # each brings plant and FMU closer by the step times sigma1/2 m, a sixth at 1 ms


class Host:
    """One instance through fmpy's own methods, initialised and ready to go at t = 0."""

    def __init__(self, path: Path, folder: Path, kind: type) -> None:
        description = fmpy.read_model_description(str(path))
        self.three, self.exchange = kind in (FMU3Model, FMU3Slave), kind in (FMU2Model, FMU3Model)
        self.references = {variable.name: variable.valueReference for variable in description.modelVariables}
        interface = description.modelExchange if self.exchange else description.coSimulation
        self.fmu: Any = kind(
            guid=description.guid,
            unzipDirectory=fmpy.extract(str(path), unzipdir=str(folder)),
            modelIdentifier=interface.modelIdentifier,
            instanceName="friction",
        )
        self.fmu.instantiate()
        for variable in description.modelVariables:
            if variable.name in VALUES:
                self._give(variable, VALUES[variable.name])
        self._initialise()
        rates = [unknown.variable.derivative.name for unknown in description.derivatives]
        self.count, self.place = len(rates), rates.index("bristle_deflection")
        self.states, self.rates = (ctypes.c_double * self.count)(), (ctypes.c_double * self.count)()
        self.slip, self.force = [self.references["slip_velocity"]], [self.references["friction_force"]]
        self.set_real = self.fmu.setFloat64 if self.three else self.fmu.setReal
        self.get_real = self.fmu.getFloat64 if self.three else self.fmu.getReal
        self.set_states = self.fmu.setContinuousStates if self.exchange else None
        self.get_rates = (self.fmu.getContinuousStateDerivatives if self.three else self.fmu.getDerivatives) if self.exchange else None

    def _give(self, variable: Any, value: float | str | bool) -> None:
        if isinstance(value, str):
            value = next(int(item.value) for item in variable.declaredType.items if item.name == value)
            (self.fmu.setInt64 if self.three else self.fmu.setInteger)([variable.valueReference], [value])
        else:
            (self.fmu.setFloat64 if self.three else self.fmu.setReal)([variable.valueReference], [value])

    def _initialise(self) -> None:
        if not self.three:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if self.exchange:
            while (self.fmu.updateDiscreteStates if self.three else self.fmu.newDiscreteStates)()[0]:
                pass
            self.fmu.enterContinuousTimeMode()

    def friction(self, t: float, v: float, z: float) -> tuple[float, float]:
        """Force and rate of the bristle: model exchange."""
        self.fmu.setTime(t)
        self.states[self.place] = z
        self.set_states(self.states, self.count)
        self.set_real(self.slip, [v])
        self.get_rates(self.rates, self.count)
        return self.get_real(self.force)[0], self.rates[self.place]

    def step(self, t: float, h: float, v_0: float, v_1: float) -> float:
        """Force at the end of a step over which the slip velocity goes from v_0 to v_1: co-simulation.

        FMI 2 takes the slope; FMI 3 has none, so the mean over the step, and then the end's velocity for the force there.
        """
        if self.three:
            self.set_real(self.slip, [(v_0 + v_1) / 2])
            self.fmu.doStep(t, h)
            self.set_real(self.slip, [v_1])
        else:
            self.set_real(self.slip, [v_0])
            self.fmu.setRealInputDerivatives(self.slip, [1], [(v_1 - v_0) / h])
            self.fmu.doStep(t, h)
        return float(self.get_real(self.force)[0])

    def follow(self, plant: Plant, h: float) -> Motion:
        """The motion in communication steps of h, each repeated from the same FMU state."""
        count = round(plant.times[-1] / h)
        y, rows = np.array(plant.start, dtype=float), np.empty((count + 1, 4))
        self.set_real(self.slip, [plant.velocity(0, y)])
        F = self.get_real(self.force)[0]
        rows[0] = 0, y[0] if y.size else np.nan, plant.velocity(0, y), F
        for n in range(count):
            t, v = n * h, rows[n, 2]
            rates = np.array(plant.rates(t, y, F))
            end, state = y + h * rates, self.fmu.getFMUState()
            for again in range(PASSES):
                if again:
                    self.fmu.setFMUState(state)
                F = self.step(t, h, v, plant.velocity(t + h, end))
                end = y + h / 2 * (rates + np.array(plant.rates(t + h, end, F)))
            self.fmu.freeFMUState(state)
            y = end
            rows[n + 1] = t + h, y[0] if y.size else np.nan, plant.velocity(t + h, y), F
        return Motion(*rows.T)


Make = Callable[[type], Host]
FollowPlant = Callable[[Plant, float], Motion]


@pytest.fixture
def host(fmi2_fmu: Path, fmi3_fmu: Path, tmp_path: Path) -> Iterator[Make]:
    made: list[Host] = []

    def make(kind: type) -> Host:
        folder = tmp_path / str(len(made))  # one each: a library that is loaded must not be unpacked over
        made.append(Host(fmi3_fmu if kind in (FMU3Model, FMU3Slave) else fmi2_fmu, folder, kind))
        return made[-1]

    yield make
    for one in made:
        one.fmu.terminate()
        one.fmu.freeInstance()


ELSE = pytest.mark.campaign  # each version and each kind of interface once in each run


@pytest.fixture(
    params=[pytest.param(FMU2Model, marks=ELSE), FMU3Model, FMU2Slave, pytest.param(FMU3Slave, marks=ELSE)],
    ids=["fmi2-me", "fmi3-me", "fmi2-cs", "fmi3-cs"],
)
def follow(request: pytest.FixtureRequest, host: Make) -> FollowPlant:
    """The plant's motion; the second number is the communication step of co-simulation."""
    one = host(request.param)
    return lambda plant, h: published.follow(plant, one.friction) if one.exchange else one.follow(plant, h)


def test_presliding_displacement(follow: FollowPlant) -> None:
    simulated = published.presliding(follow(published.presliding_plant(), 1e-3))
    assert simulated == pytest.approx(published.PRESLIDING, abs=published.TOLERANCE["presliding"])


# The kernel meets every published rate (laws/test_lugre_1995.py); the doors a slow and a fast one, and in the campaign all.
@pytest.mark.parametrize(
    "rate", [rate if rate in (1, 30) else pytest.param(rate, marks=pytest.mark.campaign) for rate in published.BREAK_AWAY]
)
def test_break_away_force_falls_with_the_rate_of_the_force(follow: FollowPlant, rate: float) -> None:
    plant = published.break_away_plant(rate)
    simulated = published.break_away(follow(plant, plant.times[-1] / max(2000, 2000 / rate)))
    assert simulated == pytest.approx(published.BREAK_AWAY[rate], abs=published.TOLERANCE["break_away"])


@pytest.mark.parametrize("w", published.LAG)
def test_friction_lags_the_velocity(follow: FollowPlant, w: float) -> None:
    plant = published.lag_plant(w)
    motion = follow(plant, plant.times[-1] / 8000)
    F = motion.F if motion.t.size == 3 else motion.F[[0, 7000, 8000]]  # the passages, at 14/3 and 16/3 pi
    simulated = (F[1], F[2])
    assert simulated == pytest.approx(published.LAG[w], abs=published.TOLERANCE["lag"])


def test_stick_slip(follow: FollowPlant) -> None:
    simulated = published.stick_slip(follow(published.stick_slip_plant(), 1e-3))
    assert simulated == pytest.approx(published.STICK_SLIP, abs=published.TOLERANCE["ms"])


@pytest.mark.campaign  # half a minute; the kernel itself, and fmpy as an importer, hunt in each run of the tests
def test_a_servo_with_integral_action_hunts(follow: FollowPlant) -> None:
    simulated = published.hunting(follow(published.servo_plant(), 2e-3))
    expected = dict(published.HUNTING)
    assert simulated.pop("period") == pytest.approx(expected.pop("period"), abs=published.TOLERANCE["hunting_period"])
    assert simulated == pytest.approx(expected, abs=published.TOLERANCE["ms"])


@pytest.mark.parametrize("kind", [FMU2Slave, FMU3Slave])
def test_the_coupling_is_of_second_order(host: Make, kind: type) -> None:
    """Half the communication step, a quarter of the error in the displacement at break-away; against model exchange."""
    plant = published.pushed_mass(lambda t, x: 5 * t, np.array([0, 0.25]))
    exact = published.follow(plant, host(FMU3Model if kind is FMU3Slave else FMU2Model).friction).x[-1]
    errors = [abs(host(kind).follow(plant, h).x[-1] - exact) for h in (1e-3, 5e-4, 2.5e-4)]
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all((slopes > 1.85) & (slopes < 2.15))
