"""Does a host in C, of odd but legal orders, get the answer of a plain one?

Events handled and not; a state that is saved in event mode and goes on in another process; steps of 0.1 us, a hundred thousand times; a
step of no length, which is refused, and a new start; all with the log off.
"""

from __future__ import annotations

import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest
from evat.native.compile import fmi_headers, host_target

OUTPUTS = ("friction_force", "principal_force", "feed_force", "mean_friction_force", "mean_feed_force", "bristle_deflection")
LONG = 1e-2  # [s], 200 cycles, a hundred thousand steps; a state is saved in the first
Order = Callable[[str], tuple[list[str], list[float]]]


@pytest.fixture(scope="module")
def order(fmus: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Order:
    """What an order logs, and the outputs behind it."""
    folder, target = tmp_path_factory.mktemp("orders"), host_target()
    if target.system == "windows":
        pytest.skip("the host opens the library by dlopen")
    description = fmpy.read_model_description(str(fmus["evat_cut-fmi3"]))
    with zipfile.ZipFile(fmus["evat_cut-fmi3"]) as archive:
        library = archive.extract(f"binaries/{target.fmi3_folder}/{description.coSimulation.modelIdentifier}{target.extension}", folder)
    source, host = Path(__file__).with_name("host_orders.c"), folder / "host"
    flags = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{fmi_headers()}", "-ldl", "-lm"]
    subprocess.run([sys.executable, "-m", "ziglang", "cc", str(source), "-o", str(host), *flags], check=True)
    reference = {v.name: str(v.valueReference) for v in description.modelVariables}
    token, file, asked = description.guid or description.instantiationToken, str(folder / "state"), [reference[name] for name in OUTPUTS]

    def give(name: str) -> tuple[list[str], list[float]]:
        command = [str(host), library, token, name, repr(LONG), file, *asked]
        answer = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
        assert answer.returncode == 0, (name, answer.returncode, answer.stderr)
        lines = answer.stdout.splitlines()
        return lines[: -len(OUTPUTS)], [float(line) for line in lines[-len(OUTPUTS) :]]

    return give


def test_events_that_are_handled_change_nothing(order: Order) -> None:
    """An event that a host handles is settled where it is told, and not a rounding on: within the tolerance of 1e-4."""
    (said, whole), (also, early) = order("whole"), order("early")
    assert said == also == []
    assert early == pytest.approx(whole, rel=1e-4)


def test_a_state_of_event_mode_goes_on_in_another_process(order: Order) -> None:
    (_, early), (_, left) = order("early"), order("leave")
    assert left != early
    said, resumed = order("resume")
    assert (said, resumed) == ([], early)  # to the last bit


def test_a_hundred_thousand_short_steps(order: Order) -> None:
    """Within the tolerance of 1e-4 of the forces' amplitudes; the mean friction is a tenth of its own."""
    (said, short), (_, whole) = order("steps"), order("whole")
    assert said == []
    assert short == pytest.approx(whole, rel=1e-3)
    assert short != whole


def test_a_step_of_no_length_is_refused_aloud_and_a_reset_mends_it(order: Order) -> None:
    """fmi3DoStep: the size has to be above 0. An error is told with the log off, in one line."""
    (said, refused), (_, whole) = order("refused"), order("whole")
    assert [line.split()[:2] for line in said] == [["log", "3"], ["status", "3"]]
    assert "the step size is 0 s" in said[0]
    assert refused == whole
