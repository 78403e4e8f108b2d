"""Do the results that an FMU carries come out of it, in an importer that does with its inputs what the file of inputs says?"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import evidence
import numpy as np
import pytest
from evat import fmu
from evat.fmu.part_model import fmu_facts_of
from fmpy import read_model_description, simulate_fmu

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
CONSTANT = {"work_share"}  # of a cut whose speed and thickness do not change


def table(path: Path, name: str) -> np.ndarray:
    with zipfile.ZipFile(path) as archive:
        data = archive.read(f"{FOLDER}/{name}")
    return np.genfromtxt(io.BytesIO(data), delimiter=",", names=True)


@pytest.mark.parametrize(("part", "version"), [(part, 2 + place % 2) for place, part in enumerate(fmu.parts())])
def test_what_is_shipped_moves_and_comes_out_again(part: str, version: int, fmus: dict[str, Path]) -> None:
    """Nothing at rest would tell an importer's fault."""
    path, facts = fmus[f"fmi{version}" if part == "evat_contact" else f"{part}-fmi{version}"], fmu_facts_of(part)
    description = read_model_description(str(path), validate=False)
    expected = table(path, f"{facts.model_name}_ref.csv")
    columns = [name for name in expected.dtype.names or () if name != "time"]
    assert {name for name in columns if np.ptp(expected[name]) <= 1e-3 * np.max(np.abs(expected[name]))} == CONSTANT & set(columns)
    given = None
    if moved := facts.reference_results.get("inputs"):
        given = table(path, f"{facts.model_name}_in.csv")
        assert set(given.dtype.names or ()) == {"time", *moved}
        starts = {v.name: float(v.start) for v in description.modelVariables if v.causality == "input" and v.name not in moved}
        rest = np.rec.fromarrays([*(given[name] for name in given.dtype.names or ()), *(np.full(len(given), x) for x in starts.values())])
        rest.dtype.names = (*(given.dtype.names or ()), *starts)
        given = rest
    step = facts.default_experiment["stepSize"]
    result = simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        output=columns,
        stop_time=expected["time"][-1],
        step_size=step,
        output_interval=step,
        input=given,
    )
    assert len(result) == len(expected) > 500
    off = {name: np.max(np.abs(result[name] - expected[name])) / np.max(np.abs(expected[name])) for name in columns}
    assert max(off.values()) <= 1e-7, off  # the files have 9 digits
    evidence.hold("importer", max(100 * max(off.values()), 5e-7))


def test_the_slim_contacts_reverse_and_separate(fmus: dict[str, Path]) -> None:
    guideway = table(fmus["evat_guideway-fmi3"], "EvatGuideway_ref.csv")
    assert np.min(guideway["friction_force"]) < -9 < 9 < np.max(guideway["friction_force"])
    slip = table(fmus["evat_slip-fmi2"], "EvatSlip_ref.csv")
    assert 0.1 < np.mean(slip["normal_force"] == 0) < 0.5
