"""How much memory does an instance take?"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from doors.raw_fmi import Door, Instance
from evat.native import kernel
from evat.native.kernel import Contact
from fmpy import calloc, free
from opened import OpenFmu
from report import Summary

MOST = 16 * 1024  # bytes


@pytest.mark.benchmark(group="memory")
def test_memory(benchmark: Any, summary: Summary, fmi2: OpenFmu, fmi2_fmu: Path, tmp_path: Path) -> None:
    """Limit: memory. What the instance asks its host for, by the host's own allocator: two contacts (one to try a start on), the tables of
    the shell. In the first-level cache of a core (32 KiB and more) both fit."""
    asked: list[int] = []

    def allocate(count: int, size: int) -> int:
        asked.append(count * size)
        return int(calloc(count, size))

    door = Door(fmi2_fmu, tmp_path)
    instance = Instance(door, allocator=(allocate, free))
    before = sum(asked)
    instance.start()
    instance.step(0.0, 1e-3)
    running = sum(asked)
    state = len(instance.serialize())
    instance.free()

    def come_and_go() -> None:
        fmi2.instance().freeInstance()

    benchmark.pedantic(come_and_go, rounds=5)
    benchmark.extra_info.update(instance=running, contact=Contact().nbytes, state=state)
    ffi, _ = kernel.library()
    fields = dict(ffi.typeof("struct Contact").fields)
    past = 2 * sum(
        ffi.sizeof(field.type) for name, field in fields.items() if name.startswith(("past", "surface", "slip_time", "slip_given"))
    )
    summary.add(
        "memory of an FMU instance, beside its history",
        f"{running - past} bytes, and {past}",
        wanted=f"< {MOST}",
        limit=f"{(running - past) / MOST:.0%} of it",
    )
    summary.add("    of it asked for while it runs", f"{running - before} bytes", wanted="0")
    summary.add("    a contact of the kernel; a serialised FMU state", f"{Contact().nbytes}; {state} bytes")
