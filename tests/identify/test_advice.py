"""Is the motion that is advised the one that would tell, and does it keep what it promises?"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from evat import motions, parameter_sets
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.identification import Settings, identify
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel
from evat.native import kernel
from known_rigs import exact
from scipy.signal import lfilter

MODEL = ContactModel(threads=1)
SHIPPED = parameter_sets.load("regularised/al-6061")
Q = "thermal_softening.Q"
FREE = ("F_C", "sigma0", Q)
WARM = 400.0  # K
TRUTH: dict[str, float | str] = {
    **kernel.by_choice(dict(SHIPPED.values)), "kinematics": "external", "friction_law": "lugre", "proxy_source": "contact_temperature",
}  # fmt: skip
WAY = float(TRUTH["F_C"]) / float(TRUTH["sigma0"])


def rig(*trials: Trial) -> Experiment:
    signals = {
        "time": Signal("time", "t", "s", None),
        "slip_velocity": Signal("slip_velocity", "v", "m/s", "input"),
        "contact_temperature": Signal("contact_temperature", "T", "K", "input"),
        "friction_force": Signal("friction_force", "F", "N", "output"),
    }
    return exact(Experiment(Path(), "rig", "", Nominal(TRUTH, SHIPPED.effects, {}), signals, trials, None, "hash of no file"))


def recorded(name: str, times: FloatArray, slip: FloatArray, temperature: FloatArray, sd: float, seed: int, memory: float = 0.0) -> Trial:
    """memory : correlation of the noise of neighbouring samples."""
    inputs = {"slip_velocity": slip, "contact_temperature": temperature}
    clean = MODEL.simulate(Run(times, inputs, ("friction_force",)), SHIPPED.effects, {**TRUTH, "relative_tolerance": 1e-7})
    white = np.random.default_rng(seed).standard_normal(times.size + 100)
    noisy = clean["friction_force"] + sd * np.sqrt(1 - memory**2) * lfilter([1.0], [1.0, -memory], white)[100:]
    return Trial(f"{name}.csv", name, {}, times, inputs, {"friction_force": noisy})


@pytest.mark.parametrize("memory", [0.0, 0.8])
def test_temperature_steps_are_advised_where_only_they_tell(memory: float) -> None:
    """Al 6061 to and fro at one temperature: the exponent of softening is told by nothing, wherever its estimate ends. Temperature steps
    are advised; tests at the very levels that the advice names then give about the standard error that it promises."""
    times = np.arange(1000) * 1e-3
    slip = 0.05 * np.sin(4 * np.pi * times) + 3 * WAY * 50 * np.pi * np.cos(50 * np.pi * times)
    one = recorded("warm", times, slip, np.full(times.size, WARM), 0.1, 1, memory)
    identification = identify(rig(one), MODEL, FREE, Settings(search="none", seed=1))
    assert identification[Q].verdict == "not identifiable"
    assert "proxy does not vary" in identification[Q].why
    assert identification["F_C"].advice == identification["sigma0"].advice == ""
    said = re.match(
        r"temperature steps, contact_temperature of (.*) K, with strokes and reversals: with it the standard error would be about (.*) %$",
        identification[Q].advice,
    )
    assert said is not None, identification[Q].advice
    levels = [float(text) for text in said[1].split(", ")]
    assert min(levels) == WARM < max(levels)
    fastest = float(np.max(np.abs(slip)))
    heated = motions.heated(levels, WARM, "contact_temperature", [share * WAY for share in motions.AMPLITUDES], [fastest], 1000.0)
    more = [
        recorded(each.condition, each.times, each.inputs["slip_velocity"], each.inputs["contact_temperature"], 0.1, 2 + place, memory)
        for place, each in enumerate(heated)
    ]
    again = identify(rig(one, *more), MODEL, FREE, Settings(search="none", seed=1, profiles=False))
    assert again[Q].verdict == "identified"
    assert abs(again[Q].value - float(TRUTH[Q])) < 4 * again[Q].sd
    assert 100 * again[Q].sd / float(TRUTH[Q]) == pytest.approx(float(said[2]), rel=0.3)


def test_nothing_is_advised_that_cannot_be_done() -> None:
    """Without a temperature among the inputs no steps of it can be asked for; the exponent then has no advice, not a wrong one."""
    times = np.arange(1000) * 1e-3
    one = recorded("warm", times, 0.05 * np.sin(4 * np.pi * times), np.full(times.size, WARM), 0.1, 1)
    blind = replace(one, inputs={"slip_velocity": one.inputs["slip_velocity"]}, values={"contact_temperature": WARM})
    identification = identify(rig(blind), MODEL, ("F_C", Q), Settings(search="none", seed=1))
    assert identification[Q].verdict == "not identifiable"
    assert identification[Q].advice == ""
