"""Is the page on how to add a friction law true? Its code goes into a copy of the sources, and everything learns of it by asking."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from added import LAW as PAGE
from added import copied, evat, python
from evat.native.compile import source_root

CHECKS = Path(__file__).with_name("test_what_a_law_reads.py")
NAME, OWN = PAGE.name, f"{PAGE.name}.v_t"
F_C, V_T, NOISE = 10.0, 0.02, 0.05  # N, m/s, N: of the contact that is measured

# A description without the search for who depends on whom, which takes long and asks no law's name.
DESCRIBE = """
from dataclasses import replace
from evat import fmu
from evat.fmu.description import fmi2, fmi3
from evat.fmu.structure.model_structure import Structure
whole = fmu.model_of("evat_contact")
fmu.model_of = lambda part: replace(whole, structure=lambda: Structure((), (), (), (), frozenset()))
for version in (2, 3):
    print(fmu.model_description(version).decode())
"""

# Strokes of two sizes, twice each, of a contact with the page's law; believed to be Coulomb's.
RECORD = f"""
from pathlib import Path
import numpy as np
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.experiment.write import write_experiment
from evat.model import Run
from evat.models.contact import ContactModel
chance, times, trials = np.random.default_rng(1), np.arange(150) * 4e-3, []
for size in (0.03, 0.08):
    inputs = {{"slip_velocity": size * np.sin(2 * np.pi * 5 * times + 0.2)}}
    values = {{"kinematics": "external", "friction_law": "{NAME}", "F_C": {F_C}, "{OWN}": {V_T}}}
    force = ContactModel(1).simulate(Run(times, inputs, ("friction_force",)), (), values)["friction_force"]
    for repeat in range(2):
        shown = {{"friction_force": force + {NOISE} * chance.standard_normal(times.size)}}
        trials.append(Trial(f"{{size}}-{{repeat}}.csv", f"{{size}} m/s", {{}}, times, inputs, shown))
signals = {{"time": Signal("time", "t", "s", None), "slip_velocity": Signal("slip_velocity", "v", "m/s", "input"),
           "friction_force": Signal("friction_force", "F", "N", "output")}}
nominal = Nominal({{"kinematics": "external", "friction_law": "coulomb", "F_C": 0.9 * {F_C}}}, (), {{}})
write_experiment(Experiment(Path(), "rig", "", nominal, signals, tuple(trials), None, ""), Path("rig"))
"""


DIAGNOSE = """
from evat.experiment.read import read_experiment
from evat.gap import diagnose
from evat.models.contact import ContactModel
model = ContactModel(1)
some = ("direction_asymmetry", "dwell_strengthening", "sensor_gain", "sensor_offset")
model.effects = tuple(effect for effect in model.effects if effect.name in some)
assert len(model.effects) == len(some)
print(*(effect.name for effect in diagnose(read_experiment("rig", model), model).effects))
"""


@pytest.fixture(scope="module")
def added(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return copied(tmp_path_factory)


@pytest.fixture(scope="module")
def rig(added: dict[str, str], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("measured")
    done = python(added, "-c", RECORD, folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "rig"


def test_the_checks_of_all_laws_find_it_and_pass(added: dict[str, str]) -> None:
    done = python(added, "-m", "pytest", "-v", "-p", "no:cacheprovider", str(CHECKS), "-k", f"{NAME} or rivals")
    assert done.returncode == 0, done.stdout[-3000:]
    assert f"test_the_force_follows_what_the_law_reads_and_nothing_else[{NAME}] PASSED" in done.stdout


def test_the_model_description_offers_it(added: dict[str, str]) -> None:
    done = python(added, "-c", DESCRIBE)
    assert done.returncode == 0, done.stderr
    items = re.findall(rf'<Item name="{NAME}" value="(\d+)" description="([^"]+)"', done.stdout)
    (meaning,) = re.findall(r'const struct FrictionLaw.*?\.meaning = "([^"]+)"', PAGE.code, re.DOTALL)
    assert items == [("8", meaning)] * 2  # FMI 2 and FMI 3, behind the seven of the catalogue
    assert done.stdout.count(f'name="{OWN}"') == 2


def test_the_command_line_tells_of_it(added: dict[str, str], tmp_path: Path) -> None:
    told = " ".join(evat(added, "info", NAME, folder=tmp_path).stdout.split())
    assert "tanh(v / v_t)" in told
    assert OWN in told


def test_it_is_simulated(added: dict[str, str], tmp_path: Path) -> None:
    """While the ellipse cuts, slip both ways; the force is its equation at each sample, and none out of contact."""
    values = ("-v", "F_C=10 N", "-v", f"{OWN}=0.2 m/s")
    options = (*values, "--cycles", "2", "--samples", "50", "-o", "cut.csv")
    done = evat(added, "simulate", "--law", NAME, *options, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "cut.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.reader(file) if not row[0].startswith("#")]
    names = [name.partition("[")[0].strip() for name in rows[0]]
    table = np.array(rows[1:], dtype=float)
    slip, force = (table[:, names.index(name)] for name in ("slip_velocity_used", "friction_force"))
    cuts = table[:, names.index("in_contact")] > 0
    assert 20 < np.count_nonzero(cuts) < cuts.size
    assert min(-slip[cuts].min(), slip[cuts].max()) > 0.1
    assert force == pytest.approx(np.where(cuts, 10 * np.tanh(slip / 0.2), 0.0), rel=1e-9)


def test_its_parameters_are_identified(added: dict[str, str], rig: Path, tmp_path: Path) -> None:
    """From 600 samples with noise of a two-hundredth of the force: each parameter to some thousandths."""
    bounds = ("-b", f"{OWN}=0.001..0.5 m/s")
    done = evat(added, "identify", str(rig), "--law", NAME, "-f", "F_C", "-f", OWN, *bounds, "--search", "none", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    (path,) = (tmp_path / "identified").glob("*.json")
    estimates = json.loads(path.read_text(encoding="utf-8"))["parameters"]
    assert estimates["F_C"]["value"] == pytest.approx(F_C, rel=0.01)
    assert estimates[OWN]["value"] == pytest.approx(V_T, rel=0.02)


def test_a_diagnosis_tries_it_as_a_rival_law(added: dict[str, str], rig: Path) -> None:
    """Coulomb's law was believed; the new one is the cause, among all laws and some effects."""
    done = python(added, "-c", DIAGNOSE, folder=rig.parent)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [f"friction_law={NAME}"]


@pytest.mark.campaign  # the code is compiled quickly, and runs slowly
def test_the_command_tries_it_beside_all_effects(added: dict[str, str], rig: Path, tmp_path: Path) -> None:
    done = evat(added, "diagnose", str(rig), "--no-fmu", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    told = json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text(encoding="utf-8"))
    (cause,) = told["effects"]
    assert cause["name"] == f"friction_law={NAME}"


def test_every_field_and_file_that_the_page_names_is_there() -> None:
    root = source_root() / "kernel"
    header = (root / "kernel.h").read_text(encoding="utf-8")
    bodies = {name: header[header.index(f"struct {name} {{") :].partition("\n};")[0] for name in ("Point", "FrictionLaw")}
    words = {name: set(re.findall(r"\w+", re.sub(r"/\*.*?\*/", "", body, flags=re.DOTALL))) for name, body in bodies.items()}
    rows = re.findall(r"^\| (`.*?) \|.*\|$", PAGE.text, re.MULTILINE)
    assert len(rows) == 8
    for row in rows:
        assert set(re.findall(r"`(\w+)`", row)) <= words["Point"], row
    assert set(re.findall(r"`\.(\w+)`", PAGE.text)) <= words["FrictionLaw"]
    for name in re.findall(r"See `(\w+\.c)`", PAGE.text):
        assert (root / "friction" / name).is_file(), name
