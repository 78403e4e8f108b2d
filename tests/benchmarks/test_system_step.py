"""What does a communication step of a system cost, what of it is the loop's, and what do a plain loop over fmpy and MuJoCo take?"""

from __future__ import annotations

import ctypes as ct
import math
import time
from pathlib import Path
from typing import Any

import lugre_1995 as published
import numpy as np
import pytest
from coupled import motion
from evat.model import Trace
from evat.models.drive import Driver
from evat.systems.couple import NO_INPUTS, Coupled, Plan, plan
from evat.systems.model import System
from evat.systems.ssp.read import read
from python_master import PythonMaster
from report import Summary

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="systems")

COMPILED, PLAIN, ROUNDS = 10_000, 500, 5  # steps of a run
NAMES = ("stick_slip", "hunting", "feed_drive", "circular_path", "emps", "evat_turning")
STOP = 28.0  # s, in which the block slips four times
HOLLOW = {"DoStep": "step_2", "SetReal": "take_2", "GetReal": "show_2", "SetRealInputDerivatives": "take_slopes_2"}


def steps_of(system: System, count: int) -> Plan:
    assert system.step is not None
    return plan(system, stop=count * system.step, every=50)


def compiled(system: System) -> float:
    """Processor seconds of a step; loading is not timed."""
    with Coupled(system) as coupled:
        begin = time.process_time()
        coupled.run(steps_of(system, COMPILED))
        return (time.process_time() - begin) / COMPILED


def plain(system: System, folder: Path) -> float:
    master = PythonMaster(system, NO_INPUTS, folder, steps_of(system, PLAIN))
    begin = time.process_time()
    master.run()
    took = (time.process_time() - begin) / PLAIN
    master.close()
    return took


def hollow(system: System, loops: ct.CDLL) -> float:
    """The same loop over functions that do nothing: the step's limit, were the FMUs free. No input is what it was in the step before, so
    that all are set."""

    def address(_: Driver, function: str) -> int:
        return ct.cast(getattr(loops, HOLLOW[function.removeprefix("fmi2")]), ct.c_void_p).value or 0

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Driver, "_address", address)
        return compiled(system)


@pytest.mark.parametrize("name", NAMES)
def test_a_step_of_a_system(benchmark: Any, summary: Summary, loops: ct.CDLL, systems: dict[str, Path], tmp_path: Path, name: str) -> None:
    """tests/systems/test_compiled_steps.py holds both to the same bits."""
    system, seconds = read(systems[name], tmp_path / "read"), dict.fromkeys(("compiled", "plain", "loop alone"), math.inf)
    for n in range(ROUNDS):
        took = {"compiled": compiled(system), "plain": plain(system, tmp_path / str(n)), "loop alone": hollow(system, loops)}
        seconds = {kind: min(seconds[kind], took[kind]) for kind in seconds}
    benchmark.pedantic(lambda: compiled(system), rounds=1)
    ratio, share = seconds["plain"] / seconds["compiled"], seconds["loop alone"] / seconds["compiled"]
    benchmark.extra_info.update(seconds)
    summary.add(
        f"{name}: a step of {len(system.components)} components",
        f"{seconds['compiled'] * 1e6:.1f} us, {ratio:.0f} times cheaper than in Python",
        wanted="<= 2 us" if name == "stick_slip" else "",
        limit=f"the FMUs' own {seconds['compiled'] * 1e6 * (1 - share):.2f} us; the loop {seconds['loop alone'] * 1e6:.2f} us, {share:.0%}",
    )
    assert ratio >= 10
    assert share <= 0.3


def of_mujoco(mujoco: Any, system: System, integrator: str) -> tuple[float, float, float]:
    """The period of the block [s], and processor seconds of a step in a loop in Python and in MuJoCo's own, in C."""
    from mujoco import rollout

    friction, drive, path = (system.components[name].values for name in ("guideway", "drive", "path"))
    lugre = " ".join(str(friction[name]) for name in ("sigma0", "sigma1", "F_C", "F_S", "v_s"))
    spring, size = float(drive["pid_gain"]), system.step
    assert size is not None
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{size}" gravity="0 0 0" integrator="{integrator}">
              <flag constraint="disable" contact="disable"/></option>
            <worldbody><body><joint name="table" type="slide" axis="1 0 0" stiffness="{spring}" damping="{friction["sigma2"]}"/>
              <geom type="sphere" size="0.1" mass="{drive["table_mass"]}"/></body></worldbody>
            <actuator><motor joint="table"/>
              <dcmotor joint="table" motorconst="1" resistance="1e9" lugre="{lugre}"/></actuator></mujoco>"""
    )
    count = round(STOP / size)
    pulls = np.zeros((1, count, 2))
    pulls[0, :, 0] = spring * float(path["speed"]) * size * np.arange(count)
    start = np.zeros((1, mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)))
    from_python = in_c = math.inf
    for _ in range(ROUNDS):
        begin = time.process_time()
        states, _ = rollout.rollout(model, mujoco.MjData(model), start, pulls)
        in_c = min(in_c, (time.process_time() - begin) / count)
        data, step = mujoco.MjData(model), mujoco.mj_step
        control = data.ctrl
        begin = time.process_time()
        for pull in pulls[0, :, 0]:
            control[0] = pull
            step(model, data)
        from_python = min(from_python, (time.process_time() - begin) / count)
    times, velocity = states[0, :, 0], states[0, :, 2]
    return float(np.diff(published.crossings(times, velocity - 0.05)).mean()), from_python, in_c


def of_ours(system: System) -> tuple[float, float]:
    """The same of the three FMUs."""
    least = math.inf
    for _ in range(ROUNDS):
        with Coupled(system, {"guideway": {"damping_mode": "as_published"}}) as coupled:
            planned = plan(system, stop=STOP, every=1)
            begin = time.process_time()
            trace: Trace = coupled.run(planned)[0]
            least = min(least, (time.process_time() - begin) / planned.count)
    return published.stick_slip(motion(trace))["period"], least


def exact(system: System) -> float:
    """The period by LSODA at 1e-9, on the law as it is published."""
    values = {name: float(value) for name, value in system.components["guideway"].values.items() if isinstance(value, float | int)}
    s_0, s_1, s_2, F_C, F_S, v_s = (values[name] for name in ("sigma0", "sigma1", "sigma2", "F_C", "F_S", "v_s"))

    def friction(_: float, v: float, z: float) -> tuple[float, float]:
        dz = v - s_0 * abs(v) / (F_C + (F_S - F_C) * math.exp(-min((v / v_s) ** 2, 700))) * z
        return s_0 * z + s_1 * dz + s_2 * v, dz

    return published.stick_slip(published.follow(published.stick_slip_plant(STOP), friction))["period"]


def test_stick_slip_beside_mujoco(benchmark: Any, summary: Summary, systems: dict[str, Path], tmp_path: Path) -> None:
    """One simulator whose table carries the bristle, and no exchange between parts: it could do without any loop of ours."""
    mujoco = pytest.importorskip("mujoco", reason="mujoco is not installed: pip install mujoco")
    system = read(systems["stick_slip"], tmp_path / "read")
    true, (period, seconds) = exact(system), of_ours(system)
    off = abs(period / true - 1)
    benchmark.pedantic(lambda: compiled(system), rounds=1)
    benchmark.extra_info.update(ours=seconds, off=off)
    summary.add("stick_slip at 1 ms, period", f"off by {off:.4%}, {seconds * 1e6:.1f} us a step", wanted="<= 0.02 %")
    for integrator in ("Euler", "RK4"):
        theirs, from_python, in_c = of_mujoco(mujoco, system, integrator)
        theirs_off = abs(theirs / true - 1)
        summary.add(f"    MuJoCo, {integrator}", f"off by {theirs_off:.4%}, {from_python * 1e6:.1f} us, {in_c * 1e6:.1f} in C")
        assert off < theirs_off
        assert seconds < from_python
    assert off < 2e-4
