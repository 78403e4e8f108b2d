"""Does the paper's table 2 come out under the inferred conditions, and does the study say what its eight means determine?

Figures of the study named by others are held to the last digit that they were given with; those of our own run are named frozen.
"""

from __future__ import annotations

import io
import json
import re
from pathlib import Path

import numpy as np
import pytest
from browser import check_layout
from evat import parameter_sets, simulate
from evat.commands.main import app
from evat.commands.tables import WholeTable
from evat.fmu.archive import RELEASED
from evat.identification.searching.journal import JournalError
from evat.model import FloatArray, ParameterError
from evat.native import kernel
from evat.paper import tables as paper_tables
from evat.paper.conditions import conditions, inference, inferred, shear_stresses
from evat.studies import main_job, main_job_report
from evat.studies.main_job import FORCES, MODELS
from evat.studies.paper import result, study
from evat.studies.paper.domain import domain_shares
from evat.studies.paper.means import (
    FINE,
    Calculation,
    cycle_means,
    deviations,
    forces_at,
    inferred_point,
    mean_error,
    measured,
    separates,
    solved_shear_stress,
)
from rich.console import Console
from typer.testing import CliRunner

MATERIALS = tuple(paper_tables.materials())
STRESS = np.array([one.inferred for one in shear_stresses().values()])
ENERGY, SHEAR = "minimum_energy", "maximum_shear_stress"


def how(model: str, principle: str = ENERGY, speed_unit: str = "m/min") -> Calculation:
    return Calculation(model, principle, speed_unit)


def directly(material: str, model: str, values: dict[str, float | str]) -> FloatArray:
    """Mean forces of the third cycle of a run of its own, from the bottom of the path."""
    loaded = parameter_sets.load(f"regularised/{material}")
    chosen = {**kernel.by_choice(loaded.values), "relative_tolerance": 1e-7, **values, "friction_law": MODELS[model].law}
    names = [f"mean_{force}" for force in FORCES]
    trace = simulate(chosen, loaded.effects if MODELS[model].with_effects else (), cycles=3, outputs=names)
    return np.array([trace[name][-1] for name in names])


@pytest.mark.parametrize(("model", "percent"), [("coulomb", 48.5), ("lugre", 16.5), ("lugre_thermal", 11.0)])
def test_the_inferred_conditions_give_the_ranking_of_the_paper(model: str, percent: float) -> None:
    assert 100 * mean_error(study.inferred_forces()[model] / measured() - 1) == pytest.approx(percent, abs=0.06)


@pytest.mark.parametrize(("model", "frozen_percent"), [("coulomb", 35.5), ("lugre", 22.8), ("lugre_thermal", 18.7)])
def test_the_ranking_outlives_the_other_closure(model: str, frozen_percent: float) -> None:
    """The chip flows by the shear angle of the moment; forces against those of runs of their own."""
    forces = study.inferred_forces("current_shear_angle")[model]
    assert 100 * mean_error(forces / measured() - 1) == pytest.approx(frozen_percent, abs=0.06)
    for place, material in enumerate(MATERIALS):
        expected = directly(material, model, {**inferred(material), "chip_flow_angle": "current_shear_angle", "relative_tolerance": 1e-4})
        assert np.abs(forces[place] - expected).max() < 1e-3 * measured()[place].max()


@pytest.mark.parametrize("material", MATERIALS)
def test_the_batch_gives_what_a_run_of_its_own_gives(material: str) -> None:
    """1e-4 of the measured force: means of a resolved run are right to that (averaging of steps at the edges of the cycle)."""
    place = MATERIALS.index(material)
    for model in MODELS:
        expected = directly(material, model, inferred(material))
        assert np.abs(study.inferred_forces()[model][place] - expected).max() < 1e-4 * measured()[place].max(), model


def test_forces_at_another_frequency_are_those_of_the_slower_vibration() -> None:
    """The batch runs everything at one frequency with speeds in proportion; that is exact, so errors of the integrator alone are left."""
    point = inferred_point()
    names = [one.variable for one in conditions()]
    point[names.index("vibration_frequency")] = 33e3
    for place, material in enumerate(MATERIALS):
        expected = directly(material, "lugre_thermal", {**inferred(material), "vibration_frequency": 33e3})
        forces = forces_at(point, STRESS, how("lugre_thermal"))[place]
        assert np.abs(forces - expected).max() < 1e-4 * measured()[place].max()


@pytest.mark.parametrize("principle", [ENERGY, SHEAR])
def test_shear_stress_moves_the_principal_force_alone_and_upward(principle: str) -> None:
    """What lets the search leave it out. The integrator's steps see it, so the feed force moves by its tolerance."""
    stress = np.repeat(np.geomspace(3e7, 2e9, 9)[None, None], len(MATERIALS), axis=1)
    forces = cycle_means(inferred_point()[None], stress, how("lugre_thermal", principle), FINE)[0]
    assert np.all(np.diff(forces[:, :, 0], axis=1) > 0)
    assert np.ptp(forces[:, :, 1], axis=1).max() < 1e-4 * measured().max()


def test_width_and_shear_stress_are_known_by_their_product_alone() -> None:
    names = [one.variable for one in conditions()]
    wider = inferred_point()
    wider[names.index("width")] *= 2
    for model in MODELS:
        one, other = forces_at(inferred_point(), STRESS, how(model)), forces_at(wider, STRESS / 2, how(model))
        assert np.abs(one - other).max() < 1e-9 * measured().max()


def test_each_inferred_shear_stress_is_what_the_principal_force_asks_for() -> None:
    solved = solved_shear_stress(inferred_point()[None], study.chosen())[0]
    assert solved == pytest.approx(STRESS, rel=5e-3)  # rounded to MPa, and the measured means to their last digit


def test_deviations_are_those_at_the_solved_shear_stress() -> None:
    """The search looks at the ends of the bounds alone; Coulomb's law asks for stresses within them, LuGre by shear stress for less."""
    for one in (how("coulomb"), how("lugre", SHEAR), how("lugre_thermal")):
        stress = solved_shear_stress(inferred_point()[None], one)[0]
        expected = forces_at(inferred_point(), stress, one) / measured() - 1
        assert deviations(inferred_point()[None], one, FINE)[0] == pytest.approx(expected, abs=1e-5)


# Where each law is best in a study with seed 0: conditions in their order, SI; errors in per cent. Those with 28.4, 14.7 and 10.1 % under
# minimum energy were found elsewhere too; under maximum shear stress 17.3 and 13.8 % were, above ours.
FROZEN_BEST = [
    ("coulomb", ENERGY, "m/min", [29176.0, 4.584e-06, 1.6179e-06, 0.51322, 0.00016025, 0.00018618, 0.46509], 28.36),
    ("lugre", ENERGY, "m/min", [35210.0, 3.1653e-06, 2.6292e-06, 0.69146, 7.1251e-05, 0.00020364, 0.35489], 14.55),
    ("lugre_thermal", ENERGY, "m/min", [26459.0, 2.8957e-06, 4.26e-06, 0.45443, 8.3917e-05, 0.00016426, 0.52963], 10.12),
    ("coulomb", SHEAR, "m/min", [29176.0, 4.584e-06, 1.6179e-06, 0.51322, 0.00016025, 0.00018618, 0.46509], 28.36),
    ("lugre", SHEAR, "m/min", [17880.0, 2.2063e-06, 2.7372e-06, 0.20932, 3.7657e-05, 0.00040377, 0.70988], 15.79),
    ("lugre_thermal", SHEAR, "m/min", [20384.0, 3.3245e-06, 3.3744e-06, 0.29488, 1.8191e-05, 0.00098935, 0.732], 11.22),
    ("lugre", ENERGY, "m/s", [28962.0, 8.3753e-06, 1.9999e-05, 1.5239, 5.5308e-05, 0.00046662, 0.75742], 24.28),
    ("lugre_thermal", ENERGY, "m/s", [28962.0, 8.3753e-06, 1.9999e-05, 1.5239, 5.0629e-05, 0.00040313, 0.75741], 24.30),
]


@pytest.mark.parametrize(("model", "principle", "speed_unit", "frozen_point", "frozen_percent"), FROZEN_BEST)
def test_each_law_at_its_own_best(model: str, principle: str, speed_unit: str, frozen_point: list[float], frozen_percent: float) -> None:
    deviation = deviations(np.array([frozen_point]), how(model, principle, speed_unit), FINE)
    assert 100 * mean_error(deviation)[0] == pytest.approx(frozen_percent, abs=0.05)


def test_the_fit_leaves_the_domain_of_the_model() -> None:
    shares = {material: domain_shares(material) for material in MATERIALS}
    none = {"copper": 0.29, "al-6061": 0.32, "al-7075-t6": 0.0, "inconel-718": 0.0}
    beyond = {"copper": 0.69, "al-6061": 0.74, "al-7075-t6": 0.04, "inconel-718": 0.04}
    floor = {"copper": 0.0, "al-6061": 0.45, "al-7075-t6": 0.0, "inconel-718": 0.87}
    for material, one in shares.items():
        assert one.no_normal_force == pytest.approx(none[material], abs=0.01)
        assert one.beyond_normal_force == pytest.approx(beyond[material], abs=0.01)
        assert one.stiffness_at_floor == pytest.approx(floor[material], abs=0.01)


@pytest.fixture(scope="module")
def cases(fmi3_fmu: Path) -> list[main_job.MainJobCase]:
    """The runs of `evat run` with fewer cycles, and few samples in each: means are kept by the component, not by its samples."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(main_job, "CYCLES", 3)
        patch.setattr(main_job, "SAMPLES_PER_CYCLE", 40)
        return main_job.run_cases(fmi3_fmu, inference().family, inference().speed_unit)


@pytest.mark.slow
def test_the_main_job_shows_the_study_s_means_through_the_fmu(cases: list[main_job.MainJobCase]) -> None:
    """1e-3 of the measured force: the FMU runs at the tolerance it has at its start, 1e-4."""
    assert len(cases) == main_job.case_count()
    for model, expected in study.inferred_forces().items():
        for place, material in enumerate(MATERIALS):
            [case] = [
                one
                for one in cases
                if (one.material, one.model, one.principle, one.conditions) == (material, model, ENERGY, main_job.INFERRED)
            ]
            means = np.array([case.means[force] for force in FORCES])
            assert np.abs(means - expected[place]).max() < 1e-3 * measured()[place].max(), (model, material)


@pytest.mark.slow
def test_its_page_fits_screen_phone_and_paper(cases: list[main_job.MainJobCase], fmi3_fmu: Path, tmp_path: Path) -> None:
    figures = main_job.plot_cases(cases, tmp_path)
    check_layout(main_job_report.write_report(cases, figures, (), inference().family, inference().speed_unit, tmp_path, fmi3_fmu))


@pytest.mark.slow
def test_the_main_job_says_which_conditions_are_guessed(cases: list[main_job.MainJobCase], fmi3_fmu: Path, tmp_path: Path) -> None:
    shares = tuple(domain_shares(material) for material in MATERIALS)
    written = main_job_report.write_report(cases, [], shares, inference().family, inference().speed_unit, tmp_path, fmi3_fmu)
    page = written.read_text(encoding="utf-8")
    text = " ".join(re.sub(r"<[^>]*>", " ", page).split())
    assert f"{fmi3_fmu.name} of {RELEASED}, model" in text
    for column, number, which in ((4, "25.2", main_job.GUESSED), (8, "10.5", main_job.INFERRED)):
        copper = main_job_report.means_table(cases, which)[0]
        assert copper[column] == number
        assert f"table 2 [N], {which} conditions" in text
    assert main_job_report.means_table(cases, main_job.INFERRED)[-1][3:] == ("43.7", "48.5", "32.8", "16.5", "25.3", "11.0")
    assert text.index("[N], inferred conditions") < text.index("[N], guessed conditions")
    for said in (
        "inferred, not known",
        "how the conditions were made, and no proof",
        "0.3 mm",
        "1089 MPa",
        "Al 6061 32 %",
        "evat study paper",
    ):
        assert said in text, said
    lines = main_job_report.write_means(cases, tmp_path / "means.csv").read_text(encoding="utf-8").splitlines()
    assert [sum(f",{which}," in line for line in lines) for which in main_job_report.BOTH] == [24, 24]


@pytest.mark.slow
def test_its_tables_fit_a_hundred_columns(cases: list[main_job.MainJobCase]) -> None:
    """A line for each mean, none of them broken."""
    for which in main_job_report.BOTH:
        table = WholeTable(*main_job_report.means_columns(), collapse_padding=True)
        lines = main_job_report.means_table(cases, which)
        for line in lines:
            table.add_row(*line)
        shown = io.StringIO()
        Console(file=shown, width=100).print(table)
        rows = [re.split(r"\s*│\s*", text.strip("│ \n")) for text in shown.getvalue().splitlines() if text.startswith("│")]
        assert [tuple(row) for row in rows] == lines


def test_inferred_conditions_lie_within_their_bounds_and_say_where_from() -> None:
    for one in (*conditions(), *shear_stresses().values()):
        assert one.low < one.inferred < one.high
        assert one.source
    assert separates(inferred_point()[None])[0]
    assert inference().model in MODELS
    assert inference().principle in kernel.variable("shear_angle_principle").choices


def test_a_tool_that_does_not_leave_the_chip_has_no_deviations() -> None:
    names = [one.variable for one in conditions()]
    point = inferred_point()
    point[names.index("cutting_speed")] = 1.001 * 2 * np.pi * 20e3 * 5e-6
    assert np.isinf(deviations(point[None], how("coulomb"))).all()


@pytest.mark.parametrize(
    ("errors", "ends", "verdict"),
    [
        ([0.1, 0.1, 0.1], (1.0, 100.0), "not determined"),
        ([0.3, 0.1, 0.1], (10**0.5, 100.0), "bounded below"),
        ([0.1, 0.1, 0.3], (1.0, 10**1.5), "bounded above"),
        ([0.3, 0.1, 0.3], (10**0.5, 10**1.5), "bounded, not determined"),
        ([2.1, 0.1, 2.1], (10**0.95, 10**1.05), "determined"),
        ([np.inf, 0.1, 0.3], (10.0, 10**1.5), "bounded, not determined"),
    ],
)
def test_a_profile_says_what_is_determined(errors: list[float], ends: tuple[float, float], verdict: str) -> None:
    one = result.ConditionProfile(conditions()[0], np.array([1.0, 10.0, 100.0]), np.array(errors), 0.2)
    assert one.interval == pytest.approx(ends)
    assert one.verdict == verdict


def test_the_ranking_is_kept_only_where_each_law_is_better_than_the_one_before() -> None:
    errors = np.array([[0.3, 0.3, 0.1, np.inf], [0.2, 0.1, 0.2, 0.2], [0.1, 0.1, 0.3, 0.1]])
    assert result.ranked(errors).tolist() == [True, False, False, True]


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """A study of some seconds: all stages, none of them converged."""
    for name, number in {"GENERATIONS": 1, "POLISHED": 9, "PROFILE_POLISHED": 2, "PROFILE_PLACES": 3, "PROFILE_DRAWS": 2}.items():
        monkeypatch.setattr(study, name, number)


@pytest.mark.usefixtures("short")
def test_a_study_goes_on_where_it_was_stopped_to_the_same_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    journal, told = tmp_path / "study.journal", list[str]()
    whole = study.study_paper(draws=64, journal=journal, progress=told.append)
    assert len(told) == study.stage_count()
    lines = journal.read_bytes().splitlines(keepends=True)
    assert len(lines) == 1 + len(told)
    journal.write_bytes(b"".join(lines[:9]) + lines[9][:40])  # torn while it was written
    calls = list[int]()
    direct = study._lowest
    monkeypatch.setattr(study, "_lowest", lambda start, how, seed: (calls.append(1), direct(start, how, seed))[1])
    again = study.study_paper(draws=64, journal=journal, resume=True)
    assert len(calls) == sum(text.startswith("best") for text in told[8:])
    for one, best in whole.best.items():
        assert again.best[one].point.tolist() == best.point.tolist()
        assert again.best[one].forces.tolist() == best.forces.tolist()
    assert [one.errors.tolist() for one in again.profiles] == [one.errors.tolist() for one in whole.profiles]
    assert journal.read_bytes() == b"".join(lines)
    with pytest.raises(JournalError, match="seed"):
        study.study_paper(draws=64, seed=1, journal=journal, resume=True)


@pytest.mark.usefixtures("short")
def test_the_command_shows_all_of_it(tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["study", "paper", "--draws", "64", "--out", str(tmp_path / "out")], catch_exceptions=False)
    assert answer.exit_code == 0
    for text in ("ranking kept in", "not known", "Al 6061", "left out", "N = 0", "m/s"):
        assert text in answer.output
    written = json.loads((tmp_path / "out/study.json").read_text(encoding="utf-8"))
    assert written["inferred"]["models"]["lugre_thermal"]["mean_error"] == pytest.approx(0.110, abs=1e-3)
    assert written["measured"]["copper"]["feed_force"] == 8
    assert written["borne_friction"]["domain"]["copper"]["friction_beyond_normal_force"] < 1e-3
    assert written["domain"]["copper"]["friction_beyond_normal_force"] > 0.6
    assert "sticking_limit" in answer.output
    assert len(written["best"]) == len(study.calculations())
    assert {path.name for path in (tmp_path / "out").glob("*.png")} == {"table-2.png", "profiles.png", "draws.png", "cycles.png"}


@pytest.mark.parametrize("draws", [0, 63, 100])
def test_draws_are_a_power_of_two(draws: int) -> None:
    with pytest.raises(ParameterError, match="power of 2"):
        study.study_paper(draws=draws)


@pytest.mark.campaign
def test_the_whole_study() -> None:
    """Errors to half a point: the search ends in other valleys where draws, libraries or machine are others, as near as this."""
    whole = study.study_paper()
    for principle, percents in ((ENERGY, (28.4, 14.6, 10.1)), (SHEAR, (28.4, 15.8, 11.2))):
        ranking = whole.ranking(principle, "m/min")
        assert [100 * error for error in ranking.values()] == pytest.approx(percents, abs=0.5)
        _, met, kept = whole.accepted(principle, "m/min")
        assert met > 30
        assert 0.7 < kept / met < 1
        assert whole.accepted(principle, "m/s")[1] == 0
        assert min(whole.ranking(principle, "m/s").values()) > 0.23
    verdicts = {one.condition.variable: one.verdict for one in whole.profiles}
    assert "determined" not in verdicts.values()
    assert [name for name, verdict in verdicts.items() if verdict == "not determined"] == [
        "vibration_frequency",
        "feed",
        "width",
        "chip_flow_shear_angle",
    ]
    for one in whole.profiles:
        low, high = one.interval
        assert low <= one.condition.inferred <= high
        assert one.errors.min() >= whole.best[study.chosen()].error - 0.003
    left_out = {(one.material, one.model): one for one in whole.left_out}
    for material in MATERIALS:
        assert left_out[material, "coulomb"].predicted.size == 0
        plain, modified = (
            abs(left_out[material, model].median / left_out[material, model].measured - 1) for model in ("lugre", "lugre_thermal")
        )
        assert modified < plain
