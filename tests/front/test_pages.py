"""Do the pages of FMUs, systems and experiments read well in a real browser, on a phone and on paper, and do their links lead somewhere?"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import evat
import numpy as np
import pandas as pd
import pytest
from browser import check_layout
from command_line import evat as command
from evat import fmu
from evat.commands.main import app
from evat.experiment.read import scan_experiment
from evat.files.writing import put
from evat.fmu import archive, part_model
from evat.fmu.documentation import beside, contact, partner
from evat.native import kernel
from evat.plots.experiment_page import pages_on, reports_beside
from lxml import html
from typer.testing import CliRunner

PART = "tool_heat"
EVIL = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def documentation() -> dict[str, dict[str, bytes]]:
    """Of the contact and of a partner, file by file."""
    facts = fmu.facts(2)
    return {
        "evat_contact": contact.documentation_files(facts.fmu, facts.variables),
        PART: partner.documentation_files(fmu.fmu_facts_of(PART), PART),
    }


@pytest.mark.parametrize("part", ["evat_contact", PART])
def test_every_link_leads_somewhere(documentation: dict[str, dict[str, bytes]], part: str) -> None:
    """To a place on the page or to a file of the same archive; the page says what it is, and lists the files beside it."""
    files = documentation[part]
    page = html.fromstring(files["documentation/index.html"])
    places = {element.get("id") for element in page.iter() if element.get("id")}
    targets = [link.get("href") for link in page.iter("a")]
    assert len(targets) > 5
    for target in targets:
        assert target[1:] in places if target.startswith("#") else f"documentation/{target}" in files, target
    assert any(target.endswith("license.txt") for target in targets)
    assert f"Version {evat.__version__} of {archive.RELEASED}" in page.find_class("about")[0].text_content()
    assert page.find(".//meta[@name='viewport']") is not None
    assert "http" not in page.find(".//meta[@http-equiv='Content-Security-Policy']").get("content")


def test_a_cell_knows_its_head(documentation: dict[str, dict[str, bytes]]) -> None:
    """So that a phone can show it beside the number; what is empty is left out there."""
    page = html.fromstring(documentation[PART]["documentation/index.html"])
    rows = {row[0].text_content(): {cell.get("data-head"): cell for cell in row[1:]} for row in page.iter("tr")}
    part = rows["insert_capacity"]
    assert list(part) == ["unit", "start", "min", "max", "meaning", "source"]
    assert (part["unit"].text_content(), part["min"].text_content()) == ("J/K", "1e-06")
    empty = {head for head, cell in rows["stored_heat"].items() if "none" in cell.get("class", "")}
    assert empty == {"start", "min", "max"}


def test_the_documentation_of_a_slim_fmu_tells_of_nothing_that_it_lacks(documentation: dict[str, dict[str, bytes]]) -> None:
    """A guideway was drawn as a chip on a tool, moved along an ellipse, and had the thermal sets of the paper."""
    facts = fmu.fmu_facts_of("evat_guideway")
    shown = tuple(variable for variable in kernel.variables() if variable.name in facts.shown)
    pages = contact.documentation_files(facts, shown), documentation["evat_contact"]
    guideway, whole = (html.fromstring(page["documentation/index.html"]) for page in pages)
    for words in ("Cutting forces", "Path and engagement", "ellipse", "One thin shear plane", "al-7075-t6"):
        assert words in whole.text_content()
        assert words not in guideway.text_content()
    assert "The motion comes in as slip_velocity" in " ".join(guideway.text_content().split())
    assert "lugre-1995" in guideway.text_content()
    assert "The slide moves at v" in guideway.find(".//figcaption").text_content()


def test_the_picture_of_a_slim_fmu_is_of_what_it_is() -> None:
    """That of a guideway was a chip on a tool, and that of a contact whose slip is given had an ellipse."""
    drawn = {
        part: {**part_model.model_of(part).documentation(fmu.fmu_facts_of(part)), "icon.png": part_model.model_of(part).icon().png}
        for part in ("evat_contact", "evat_turning", "evat_slip", "evat_guideway")
    }
    for name in ("model.png", "documentation/diagram.png", "documentation/diagram.svg", "icon.png"):
        contact, turning, slip, guideway = (files[name] for files in drawn.values())
        assert contact == turning
        assert len({contact, slip, guideway}) == 3
    captions = [html.fromstring(files["documentation/index.html"]).find(".//figcaption").text_content() for files in drawn.values()]
    assert ["ellipse" in each for each in captions] == [True, True, False, False]
    assert ["chip" in each for each in captions] == [True, True, True, False]


def test_the_documentation_of_an_fmu_lies_beside_what_it_gave(fmi3_fmu: Path, tmp_path: Path) -> None:
    """A report of runs leads to it, and from its first page every link leads on."""
    ((link, what),) = beside(fmi3_fmu, tmp_path).items()
    assert fmi3_fmu.name in what
    page = html.fromstring((tmp_path / link).read_bytes())
    files = [each.get("href") for each in page.iter("a") if not each.get("href").startswith("#")]
    assert files
    assert all(((tmp_path / link).parent / file).is_file() for file in files)
    assert {path.name for path in tmp_path.iterdir()} == {"documentation"}


@pytest.mark.parametrize("part", ["evat_contact", PART])
def test_the_page_fits_screen_phone_and_paper(documentation: dict[str, dict[str, bytes]], part: str, tmp_path: Path) -> None:
    (tmp_path / "index.html").write_bytes(documentation[part]["documentation/index.html"])
    check_layout(tmp_path / "index.html")


@pytest.fixture(scope="module")
def of_a_system(systems: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The table of a run; its page lies beside it."""
    to = tmp_path_factory.mktemp("run") / "creep.csv"
    asked = ["system", "run", str(systems["stick_slip"]), "--stop", "0.02", "-v", "guideway.F_C=1.5 N", "-o", str(to)]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    return to


def test_the_page_of_a_system_says_what_was_run(of_a_system: Path) -> None:
    """Whether the coupling kept the power, each signal in numbers, the values with their units; its links lead to files that are there."""
    page = html.fromstring(of_a_system.with_suffix(".html").read_bytes())
    assert page.find_class("badge")[0].text_content() == "power kept"
    assert f"System of {archive.RELEASED}." in page.find_class("about")[0].text_content()
    assert "F_C = 1.5 N" in page.text_content()
    rows = {row[0].text_content(): row for row in next(page.iter("table")).iter("tr")}
    table = pd.read_csv(of_a_system)
    (force,) = (name for name in table if name.startswith("guideway.friction_force"))
    unit, at_the_end = (rows["guideway.friction_force"][place].text_content() for place in (1, 3))
    assert unit == "mN"
    assert float(at_the_end) == pytest.approx(1e3 * table[force].iloc[-1], rel=1e-3)
    named = [link.get("href") for link in page.iter("a") if not link.get("href").startswith("#")]
    assert sorted(named) == ["creep.csv", "creep.html", "creep.png"]
    assert all((of_a_system.parent / name).is_file() for name in named)


def test_the_page_of_a_run_by_a_record_says_what_the_record_feeds_and_where_it_ends(systems: dict[str, Path], tmp_path: Path) -> None:
    """The command said both, the page neither; and a step longer than the run was told as it was asked for."""
    (tmp_path / "load.csv").write_text("time [s],drive.load_force [N]\n0,0\n1,-1\n", encoding="utf-8")
    to = tmp_path / "pushed.csv"
    ran = ("system", "run", str(systems["stick_slip"]), "-i", str(tmp_path / "load.csv"), "--step", "5 s", "--stop", "2 s")
    pushed = command(*ran, "-o", str(to), folder=tmp_path, columns=1000)
    assert pushed.returncode == 0, pushed.stderr
    page = html.fromstring(to.with_suffix(".html").read_bytes())
    note = "the record of drive.load_force ends at 1 s: from there on its last values are held"
    assert note in pushed.stderr
    assert note in [each.text_content() for each in page.iter("li")]
    (components,) = (table for table in page.iter("table") if "what feeds them" in table[0].text_content())
    inputs = {row[0].text_content(): row[3].text_content() for row in components.iter("tr")}
    assert inputs["drive"].endswith("position_reference: path.position_x, load_force: the record")
    assert (inputs["path"], inputs["guideway"]) == ("none", "slip_velocity: drive.table_velocity")
    assert "ran from 0 to 2 s in steps of 2 s." in page.text_content()
    assert "communication step 2.0 s, 1 steps" in page.text_content()


def test_the_page_of_a_system_fits_screen_phone_and_paper(of_a_system: Path) -> None:
    check_layout(of_a_system.with_suffix(".html"))


@pytest.fixture(scope="module")
def of_an_experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a rig in millimetres, its page, and what was identified from it."""
    folder = tmp_path_factory.mktemp("lab")
    made = evat.orthogonal({"friction_law": "coulomb", "F_C": 8.0}, motion="reversal", repeats=2, speeds=[0.5], rate=20.0)
    evat.write_experiment(replace(made, title=f"rig {EVIL}"), folder / "rig")
    read = scan_experiment(folder / "rig", evat.ContactModel())
    for name, of in (("diagnosed", read.data_hash), ("of_other_data", "another")):  # what a diagnosis leaves, as far as others look at it
        put(folder / name / "diagnosis.json", json.dumps({"made_by": {"data": of}}))
        put(folder / name / "report.html", "a report")
    for asked in (
        ["experiment", "check", str(folder / "rig"), "-o", str(folder / "rig" / "experiment.html")],
        ["identify", str(folder / "rig"), "-f", "F_C", "--search", "none", "-o", str(folder / "identified")],
        ["experiment", "check", str(folder / "rig"), "-o", str(folder / "rig" / "experiment.html")],
    ):
        result = CliRunner().invoke(app, asked)
        assert result.exit_code == 0, result.output
    return folder


def test_the_page_of_an_experiment_leads_to_its_reports_and_back(of_an_experiment: Path) -> None:
    """To those of its data and no others; what was read stands in its tables, and a title stays text."""
    place = of_an_experiment / "rig" / "experiment.html"
    page = html.fromstring(place.read_bytes())
    targets = [link.get("href") for link in page.iter("a") if not link.get("href").startswith("#")]
    assert "../identified/report.html" in targets
    assert all((place.parent / target).is_file() for target in targets)
    assert page.find(".//h1").text_content() == f"rig {EVIL}"
    assert page.find(".//script") is None
    rows = {row[0].text_content(): [cell.text_content() for cell in row] for row in page.iter("tr")}
    assert rows["friction_force"][1] == "output"
    assert float(rows["friction_force"][-1].removesuffix(" N")) == pytest.approx(8.0, abs=0.5)
    report = html.fromstring((of_an_experiment / "identified" / "report.html").read_bytes())
    led_to = [link.get("href") for link in report.iter("a") if link.get("href").startswith("..")]
    assert led_to == ["../rig/experiment.html", "../diagnosed/report.html"]
    read = evat.read_experiment(of_an_experiment / "rig", evat.ContactModel())
    assert list(pages_on(read, of_an_experiment / "diagnosed" / "report.html", "diagnosis")) == [
        "../rig/experiment.html",
        "../identified/report.html",
    ]
    other = reports_beside(place, "hash of other data")
    assert other == {}


@pytest.mark.parametrize("page", ["rig/experiment.html", "identified/report.html"])
def test_the_pages_of_an_experiment_fit_screen_phone_and_paper(of_an_experiment: Path, page: str) -> None:
    check_layout(of_an_experiment / page)


def test_a_recorded_position_is_shown_as_one(tmp_path: Path) -> None:
    """It was told as the velocity that is taken from it: 250 mm as 15 m/min."""
    from evat.commands.main import app
    from evat.experiment.read import scan_experiment
    from evat.models.contact import ContactModel
    from evat.plots.experiment_page import channels_of, trials_of
    from typer.testing import CliRunner

    assert CliRunner().invoke(app, ["experiment", "example", "axis", "-o", str(tmp_path / "axis")]).exit_code == 0
    scan = scan_experiment(tmp_path / "axis", ContactModel())
    slip = next(row for row in channels_of(scan).rows if row[0].startswith("slip_velocity"))
    assert (slip[0], slip[-1]) == ("slip_velocity (its position)", "250 mm")
    assert all("mm" in row[5] for row in trials_of(scan).rows)


def test_the_rms_of_a_temperature_is_told_in_kelvins(tmp_path: Path) -> None:
    """Half the time at 0 degC, half at 200: 386.3 K, which was shown as 113.2 degC, neither the rms nor the mean of the column."""
    from evat.models.contact import ContactModel
    from evat.plots.experiment_page import channels_of, trials_of

    times = np.arange(0, 2, 0.001)
    temperature, slip = np.where(times < 1, 0.0, 200.0), 0.1 * np.sin(times)
    columns = {"time [s]": times, "slip [m/s]": slip, "temperature [degC]": temperature, "force [N]": 5 * np.tanh(100 * slip)}
    pd.DataFrame(columns).to_csv(tmp_path / "a.csv", index=False)
    signals = {
        "time": "time [s]",
        "slip_velocity": "slip [m/s]",
        "contact_temperature": "temperature [degC]",
        "friction_force": "force [N]",
    }
    lines = ["format = 1", 'title = "warm"', "[nominal]", 'friction = "lugre"', 'kinematics = "external"', "values = { F_C = 5.0 }"]
    for name, column in signals.items():
        lines += [f"[signals.{name}]", f'column = "{column}"', f'unit = "{column.split("[")[1][:-1]}"']
        lines += [] if name == "time" else [f'role = "{"output" if name == "friction_force" else "input"}"']
    (tmp_path / "experiment.toml").write_text("\n".join([*lines, "[[trials]]", 'file = "a.csv"', 'condition = "one"', ""]))
    scan = scan_experiment(tmp_path, ContactModel())
    place = trials_of(scan).heads.index("rms contact temperature")
    assert trials_of(scan).rows[0][place] == "386.3 K"
    assert trials_of(scan).rows[0][place - 1] == "0.0771 m/s"
    assert next(row for row in channels_of(scan).rows if row[0] == "contact_temperature")[-2:] == ("0 degC", "200 degC")
