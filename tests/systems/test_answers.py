"""What becomes of a run where a function of a component answers badly? The component is named, and what was computed before is kept."""

from __future__ import annotations

import ctypes as ct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from evat.model import Trace
from evat.models.drive import Driver
from evat.systems.couple import Coupled, plan
from evat.systems.model import System, SystemStopped
from evat.systems.ssp.read import read

STEPS, GOOD = 100, 50
WARNING, DISCARD, ERROR, FATAL = 1, 2, 3, 4
ONE = "guideway"  # whose functions answer badly
_flag, _numbers, _references = ct.POINTER(ct.c_bool), ct.POINTER(ct.c_double), ct.POINTER(ct.c_uint32)
FUNCTIONS: dict[str, Any] = {
    "fmi2DoStep": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, ct.c_double, ct.c_double, ct.c_int),
    "fmi3DoStep": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, ct.c_double, ct.c_double, ct.c_bool, _flag, _flag, _flag, _numbers),
    "fmi2SetReal": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, _references, ct.c_size_t, _numbers),
    "fmi2GetReal": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, _references, ct.c_size_t, _numbers),
    "fmi2SetRealInputDerivatives": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, _references, ct.c_size_t, ct.POINTER(ct.c_int), _numbers),
    "fmi3SetFloat64": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, _references, ct.c_size_t, _numbers, ct.c_size_t),
    "fmi3GetFloat64": ct.CFUNCTYPE(ct.c_int, ct.c_void_p, _references, ct.c_size_t, _numbers, ct.c_size_t),
}
Answer = Callable[..., int]  # of a function's arguments, once it has been called and went well


def status(number: int) -> Answer:
    return lambda *_: number


def ask_to_end(*arguments: Any) -> int:
    """The second of the flags that fmi3DoStep hands back."""
    arguments[5][0] = True
    return 0


def show_nan(*arguments: Any) -> int:
    arguments[3][0] = np.nan
    return 0


@pytest.fixture(scope="module")
def by_version(systems: dict[str, Path], fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, System]:
    """The same parts by both versions of FMI; the third has no derivatives of inputs."""
    plain, folder = read(systems["stick_slip"], tmp_path_factory.mktemp("plain")), fmus["fmi3"].parent
    parts = {name: replace(part, source=folder / f"{part.source.stem}-fmi3.fmu") for name, part in plain.components.items()}
    return {"fmi2": plain, "fmi3": replace(plain, components=parts)}


@pytest.fixture
def answering(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, Answer], None]:
    """Puts before a function of one component another, which calls it and, once GOOD steps are done, answers for it."""
    kept, genuine = list[Any](), Driver._address

    def put(function: str, answer: Answer) -> None:
        steps = 0

        def before(driver: Driver, name: str) -> int:
            address = genuine(driver, name)
            if driver._name != ONE or (name != function and not name.endswith("DoStep")):
                return address
            called = FUNCTIONS[name](address)

            def answered(*arguments: Any) -> int:
                nonlocal steps
                steps += name.endswith("DoStep")
                went: int = called(*arguments)
                bad = name == function and steps + ("Derivatives" in name) > GOOD  # which are set before a step
                return answer(*arguments) if bad else went

            kept.append(FUNCTIONS[name](answered))
            return ct.cast(kept[-1], ct.c_void_p).value or 0

        monkeypatch.setattr(Driver, "_address", before)

    return put


def run(system: System) -> Trace:
    assert system.step is not None
    with Coupled(system) as coupled:
        return coupled.run(plan(system, stop=STEPS * system.step, every=1))[0]


BAD: list[tuple[str, Answer, str]] = [
    ("fmi2DoStep", status(DISCARD), r"fmi2DoStep failed with status 2 \(discard\)"),
    ("fmi2DoStep", status(ERROR), r"fmi2DoStep failed with status 3 \(error\)"),
    ("fmi2SetReal", status(ERROR), r"fmi2SetReal failed with status 3 \(error\)"),
    ("fmi2SetRealInputDerivatives", status(DISCARD), r"fmi2SetRealInputDerivatives failed with status 2 \(discard\)"),
    ("fmi2GetReal", status(FATAL), r"fmi2GetReal failed with status 4 \(fatal\)"),
    ("fmi2GetReal", show_nan, r"friction_force is nan, which is no finite number"),
    ("fmi3DoStep", status(DISCARD), r"fmi3DoStep failed with status 2 \(discard\)"),
    ("fmi3DoStep", ask_to_end, r"the FMU asks that the simulation ends"),
    ("fmi3SetFloat64", status(FATAL), r"fmi3SetFloat64 failed with status 4 \(fatal\)"),
    ("fmi3GetFloat64", status(ERROR), r"fmi3GetFloat64 failed with status 3 \(error\)"),
    ("fmi3GetFloat64", show_nan, r"friction_force is nan, which is no finite number"),
]


@pytest.mark.parametrize(("function", "answer", "said"), BAD)
def test_a_bad_answer_names_the_component_and_keeps_what_came_before(
    by_version: dict[str, System], answering: Callable[[str, Answer], None], function: str, answer: Answer, said: str
) -> None:
    system = by_version[function[:4]]
    whole = run(system)
    answering(function, answer)
    where = rf"component {ONE} failed in the step at t = 0\.05 s, after {GOOD} of {STEPS} steps: "
    with pytest.raises(SystemStopped, match=where + rf"(step to t = 0\.051 s: .*)?{said}") as stopped:
        run(system)
    kept = stopped.value.trace
    assert kept.times.tobytes() == whole.times[: GOOD + 1].tobytes()
    assert [at for at, column in whole.items() if kept[at].tobytes() != column[: GOOD + 1].tobytes()] == []


@pytest.mark.parametrize("version", ["fmi2", "fmi3"])
def test_a_warning_does_not_stop_a_run(by_version: dict[str, System], answering: Callable[[str, Answer], None], version: str) -> None:
    whole = run(by_version[version])
    answering(f"{version}DoStep", status(WARNING))
    warned = run(by_version[version])
    assert [at for at, column in whole.items() if warned[at].tobytes() != column.tobytes()] == []
