"""How long does one second of 20 kHz vibration take on one core, and how right are its cycle means?"""

from __future__ import annotations

import ctypes as ct
import time
from typing import Any

import numpy as np
import pytest
from cases import FREQUENCY, PERIOD, ellipse
from evat import parameter_sets
from evat.native.kernel import Contact
from opened import OpenFmu
from report import Summary
from timing import least

pytestmark = pytest.mark.benchmark(timer=time.process_time, group="one second")

MEANS = ("mean_friction_force", "mean_principal_force", "mean_feed_force", "mean_normal_force", "mean_contact_ratio")
SETS = ("start values", "regularised/copper", "regularised/al-6061", "regularised/inconel-718", "lugre-1995")
WANTED = {"start values": "<= 0.06 s", "regularised/al-6061": "<= 0.15 s"}


def means(contact: Contact) -> np.ndarray:
    return np.array([contact.get(name) for name in MEANS])


def passed(contact: Contact, step: float) -> None:
    """1 s more, through the kernel's own call: outputs are asked for at its end."""
    run, block, taken = contact._library.kernel_advance, contact._contact, contact._taken
    for _ in range(round(1 / step)):
        assert run(block, step, 0, taken) == 0
    contact.evaluate()


@pytest.mark.parametrize("set_name", SETS)
def test_one_second(benchmark: Any, summary: Summary, loops: ct.CDLL, set_name: str) -> None:
    """Limit: arithmetic. 20 000 cycles of the ellipse with all that is switched on in the set, in communication steps of a cycle, so that
    each is run; the bare law needs as many steps of the exponential midpoint rule, timed from C, without contact, thickness, forces and
    means. In steps of 20 cycles three of them are run, and the last one of each ends where all would have led."""
    parameter_set = None if set_name == "start values" else parameter_sets.load(set_name)
    values, on = ({}, ()) if parameter_set is None else (dict(parameter_set.values), parameter_set.effects)
    contact, exact = Contact(values, on), Contact({**values, "relative_tolerance": 1e-10}, on)
    contact.start()
    exact.start()
    exact.advance(3 * PERIOD)

    long = Contact(values, on)
    long.start()
    seconds = least({"cycles": lambda: passed(contact, PERIOD), "long steps": lambda: passed(long, 20 * PERIOD)}, 3)
    steps = contact.get("step_count") / contact.time
    wrong = dict(zip(MEANS, np.abs(means(contact) / means(exact) - 1), strict=True))
    errors = f"friction to {wrong['mean_friction_force']:.0e}, principal force to {wrong['mean_principal_force']:.0e}"
    benchmark.pedantic(lambda: contact.advance(PERIOD), rounds=5)

    law, z, count = ellipse("lugre-1995").in_c(), ct.c_double(0.0), 200_000
    bare = min(
        loops.bare_steps(ct.byref(law), 1, ct.c_double(0.0), ct.c_double(PERIOD / 200), ct.c_int64(count), ct.byref(z)) for _ in range(5)
    )
    limit = bare / count * steps
    apart = float(np.max(np.abs(means(long) / means(contact) - 1)))
    benchmark.extra_info.update(
        seconds=seconds, steps_of_a_cycle=steps / FREQUENCY, error_of_means=wrong, bare=limit, long_steps_apart=apart
    )
    summary.add(
        f"1 s of 20 kHz, {set_name}: {steps / FREQUENCY:.0f} steps a cycle, {seconds['cycles'] / steps * 1e9:.0f} ns each",
        f"{seconds['cycles']:.3f} s; {errors}",
        wanted=WANTED.get(set_name, ""),
        limit=f"bare law, as many steps: {limit:.3f} s",
    )
    summary.add(
        "    in steps of 1 ms",
        f"{seconds['long steps']:.3f} s; means {apart:.0e} from those",
        wanted=WANTED.get(set_name, ""),
        limit="3 of 20 cycles",
    )


def test_one_second_through_fmpy(benchmark: Any, summary: Summary, fmi2: OpenFmu) -> None:
    """Limit: arithmetic still; a doStep of 1 ms holds 20 cycles, a call of a microsecond is nothing beside them."""
    instance, clock = fmi2.started({}), 0.0

    def ours() -> None:
        nonlocal clock
        for _ in range(1000):
            instance.doStep(clock, 1e-3)
            clock += 1e-3

    seconds = least({"ours": ours}, 3)["ours"]
    benchmark.pedantic(ours, rounds=1)
    benchmark.extra_info["seconds"] = seconds
    summary.add("    start values through fmpy, 1000 doSteps of 1 ms", f"{seconds:.3f} s", wanted=WANTED["start values"])
    instance.freeInstance()
