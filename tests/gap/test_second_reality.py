"""Can the second reality be trusted? The same seed gives the same bytes, splits share nothing, strata are hit, every case can be read,
nothing of the truth is in it, and made-up answers score what they must."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import statistics_of_scores
from evat.experiment import Trial
from evat.experiment.read import read_experiment
from evat.models.contact import ContactModel
from evat.native import kernel
from second_reality import advised, catalogue, ceiling, draw, folder, generate, run_diagnosis, scores
from second_reality.catalogue import BASE_CUTS, BASE_LAWS, EFFECTS, SPLITS, STRATA
from second_reality.draw import Case, NotDrawn, Plan
from second_reality.unknowns import KINDS, Seen

PLANS = {  # of each world and each truth one, quickly drawn
    "rig single": Plan("rig", "single", ("friction_wear",), "large", "lugre", "sharp"),
    "rig none other": Plan("rig", "none", (), "small", "lagged_coulomb", "sharp"),
    "axis unknown": Plan("axis", "unknown", ("table_jump",), "medium", "lugre", "sharp"),
    "ellipse pair": Plan("ellipse", "pair", ("edge_force", "sensor_offset"), "large", "lugre", "sharp"),
    "ellipse single other": Plan("ellipse", "single", ("process_damping",), "small", "lugre", "ploughing"),
    "means mistuned": Plan("means", "mistuned", (), "medium", "lugre", "sharp"),
    "means unknown": Plan("means", "unknown", ("speed_resonance",), "large", "lugre", "sharp"),
}


def first(plan: Plan, seed: int = 1) -> Case:
    """The first draw of a plan that comes off."""
    for attempt in range(20):
        try:
            return draw.draw_case(plan, "development", [seed, attempt])
        except NotDrawn:
            continue
    raise AssertionError(f"{plan} does not come off")


@pytest.fixture(scope="module")
def cases(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Case, Path]]:
    root = tmp_path_factory.mktemp("second")
    with np.errstate(all="ignore"):
        drawn = {name: first(plan) for name, plan in PLANS.items()}
    for k, (_, case) in enumerate(drawn.items()):
        folder.write(root / f"{k + 1:03d}", case, np.random.default_rng(k))
    return {name: (case, root / f"{k + 1:03d}") for k, (name, case) in enumerate(drawn.items())}


@pytest.mark.parametrize("name", list(PLANS))
def test_every_world_and_truth_makes_an_experiment_that_can_be_read(name: str, cases: dict[str, tuple[Case, Path]]) -> None:
    case, place = cases[name]
    experiment = read_experiment(place, ContactModel(1))
    assert set(experiment.nominal.values) >= set(case.nominal)
    if case.world.means:
        assert experiment.means is not None
        assert len(experiment.means.conditions) == len(case.trials)
    else:
        assert len(experiment.trials) == len(case.trials)
        for trial in experiment.trials:
            assert set(trial.outputs) == set(case.world.channels)
            assert set(trial.inputs) == set(case.world.inputs)
            assert trial.times.size > 50


@pytest.mark.parametrize("name", list(PLANS))
def test_the_gap_lies_in_its_stratum(name: str, cases: dict[str, tuple[Case, Path]]) -> None:
    label = cases[name][0].label
    if label["truth"] == "none":
        assert label["ratio"] == 0
        return
    low, high = STRATA[label["stratum"]]
    assert 0.9 * low < label["ratio"] < 1.1 * high
    assert label["share_of_force"] == pytest.approx(label["ratio"] * label["noise_share"])
    if label["truth"] in ("single", "pair"):
        assert max(label["gap_over_noise"].values()) == pytest.approx(label["ratio"], rel=0.12)


def test_the_noise_of_a_record_is_what_its_label_says(cases: dict[str, tuple[Case, Path]]) -> None:
    """What stands between a record and its ideal self is the noise, its outliers and the steps of the converter."""
    for name in ("rig single", "ellipse pair"):
        case = cases[name][0]
        for channel in case.world.channels:
            off = np.concatenate([t.outputs[channel] - t.ideal[channel] for t in case.trials])
            unit = np.sqrt(np.mean(np.concatenate([t.true[channel] for t in case.trials]) ** 2))
            spread = np.subtract(*np.quantile(off, [0.75, 0.25])) / 1.349 / unit
            assert 0.5 < spread / case.label["set_up"]["noise"][channel] < 1.2


@pytest.mark.parametrize(
    ("name", "factors", "column"),
    [("rig single", {"slip_velocity": 2.0}, "slip_velocity"), ("ellipse pair", {"cutting_speed": 0.5}, "cutting_speed")],
)
def test_an_advised_condition_is_recorded_by_the_same_rig(
    name: str, factors: dict[str, float], column: str, cases: dict[str, tuple[Case, Path]], tmp_path: Path
) -> None:
    case, place = cases[name]
    condition, now = next(iter(advised.recorded(place).items()))
    with np.errstate(all="ignore"):
        advised.write("001", case.label, advised.place_of(condition), factors, tmp_path)
    longer, before = (read_experiment(folder, ContactModel(1)) for folder in (tmp_path / "001", place))
    new = [trial for trial in longer.trials if trial.condition not in before.conditions]
    assert len(new) == 2 == len(longer.trials) - len(before.trials)
    for trial in new:
        seen = trial.values[column] if column in trial.values else float(np.sqrt(np.mean(trial.inputs[column] ** 2)))
        assert seen == pytest.approx(factors[column] * now[column], rel=0.05)

    def noise(trials: list[Trial]) -> float:
        """Of the sensor: what second differences show."""
        return float(np.median([np.median(np.abs(np.diff(trial.outputs[case.world.channels[0]], 2))) for trial in trials]))

    assert noise(new) == pytest.approx(noise(list(before.trials)), rel=0.6)


def test_what_was_advised_is_what_is_set() -> None:
    rng, now = np.random.default_rng(0), {"slip_velocity": 0.2, "contact_temperature": 343.15}
    assert advised.factors_of({"slip_velocity": 0.101}, now) == {"slip_velocity": 0.5}
    assert advised.factors_of({"contact_temperature": 393.0}, now) == {"contact_temperature": 2.0}
    by_lot = [advised.by_lot({"cond1": now, "cond2": now}, rng) for _ in range(40)]
    assert {condition for condition, _ in by_lot} == {"cond1", "cond2"}
    assert {name for _, factors in by_lot for name in factors} == set(now)
    assert {value for _, factors in by_lot for value in factors.values()} == set(advised.FACTORS)
    assert (advised.place_of("cond3"), advised.place_of("test 12")) == (2, 11)


def test_only_ambiguous_answers_with_an_advice_are_carried_out(tmp_path: Path) -> None:
    feed = {"condition": "cond1", "values": {"feed": 1e-5}}
    said = {"1": ("ambiguous", feed), "2": ("effect", feed), "3": ("ambiguous", None)}
    said["4"] = said["1"]
    for name, (verdict, advice) in said.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "diagnosis.json").write_text(json.dumps({"verdict": verdict, "next_experiment": advice}))
    labels = {name: {"truth": "unknown" if name == "4" else "single"} for name in (*said, "5")}
    assert advised.ambiguous(labels, tmp_path) == [("1", feed)]


def test_nothing_of_the_truth_is_in_a_case(cases: dict[str, tuple[Case, Path]]) -> None:
    words = {*EFFECTS, *KINDS, *BASE_LAWS, *BASE_CUTS} - {"lugre"}
    for case, place in cases.values():
        text = (place / "experiment.toml").read_text()
        told = {word for word in words if word in text}
        assert told <= set(case.world.nominal_effects)
        assert {path.suffix for path in place.rglob("*") if path.is_file()} <= {".toml", ".csv", ".parquet"}


def test_the_same_arguments_give_the_same_bytes_and_labels_stay_apart(tmp_path: Path) -> None:
    only: dict[str, list[str]] = {"truth": ["single"], "world": ["means"], "effect": ["edge_force", "sensor_offset"]}

    def made(name: str, split: str = "development") -> tuple[list[bytes], dict[str, Any]]:
        with np.errstate(all="ignore"):
            generate.generate(tmp_path / name, tmp_path / f"{name}_labels", split, 3, 1, only)
        files = sorted(path for path in (tmp_path / name).rglob("*") if path.is_file())
        return [path.read_bytes() for path in files], json.loads((tmp_path / f"{name}_labels/labels.json").read_text())

    bytes_1, labels = made("a")
    assert (bytes_1, labels) == made("b")
    other, _ = made("c", "kept")
    assert not set(bytes_1) & set(other)
    assert not [path for path in (tmp_path / "a").rglob("*") if "label" in path.name or "oracle" in path.name]
    assert (tmp_path / "a_labels" / "oracle" / "001.parquet").is_file()
    with pytest.raises(SystemExit, match="apart"):
        generate.generate(tmp_path / "d", tmp_path / "d" / "labels", "kept", 3, 1, only)
    with pytest.raises(SystemExit, match="other arguments"):
        generate.generate(tmp_path / "a", tmp_path / "a_labels", "development", 4, 1, only)


def test_splits_share_no_base_law_no_unknown_and_no_form_of_an_effect() -> None:
    one, two = SPLITS
    assert not set(catalogue.laws(one)) & set(catalogue.laws(two))
    assert not set(catalogue.cuts(one)) & set(catalogue.cuts(two))
    unknown = [{name for world in catalogue.WORLDS for name in catalogue.unknowns(split, world)} for split in SPLITS]
    assert not unknown[0] & unknown[1]
    assert len(unknown[0] | unknown[1]) >= 12
    for name in EFFECTS:
        forms = [set(catalogue.forms(split, name)) for split in SPLITS]
        assert all(forms)
        assert not forms[0] & forms[1]
    for split, law in ((s, w) for s in SPLITS for w in catalogue.WORLDS):
        assert catalogue.unknowns(split, law)
    assert generate.seed_of(one, 1, 0) != generate.seed_of(two, 1, 0)
    for split in SPLITS:
        plans = generate.Plans(np.random.default_rng(0), split, {})
        for plan in plans.all(150):
            assert plan.law in ("lugre", *catalogue.laws(split))
            assert plan.cut in ("sharp", *catalogue.cuts(split))
            assert not catalogue.stands_for(plan.law, plan.cut) & set(plan.effects)


@pytest.mark.parametrize("name", list(KINDS))
def test_each_unknown_is_bounded_grows_with_its_strength_and_has_chance_in_it_or_not(name: str) -> None:
    t = np.linspace(0, 1, 900)
    x, v = 1e-2 * (1 - np.cos(6 * np.pi * t)), 6e-2 * np.pi * np.sin(6 * np.pi * t)
    worlds, _, make = KINDS[name]
    means = worlds == ("means",)
    forces = {"a": np.array([2.0])} if means else {"a": 5 * np.tanh(v / 0.01)}
    act = make(np.random.default_rng(5))
    sizes = []
    for s in (0.05, 0.2):
        total = 0.0
        for place in range(10):
            values = {"cutting_speed": 0.1 * (place + 1)}
            seen = Seen(t, v, x, forces, place, 10, values, {"a": 4.0}, 2e-2, 0.19 if not means else 1.0, 10.0)
            more = act(np.random.default_rng(place), seen, s)["a"]
            assert np.all(np.isfinite(more))
            assert more.shape == forces["a"].shape
            total += float(np.mean(more**2))
        sizes.append(np.sqrt(total))
    assert 0 < 1.5 * sizes[0] < sizes[1] < 40 * sizes[0]


def answered(root: Path, name: str, verdict: str, sets: list[tuple[list[str], float]], p_value: float = 0.5) -> None:
    (root / name).mkdir(parents=True)
    effects = [{"name": n, "probability": sets[0][1], "not_separable_from": []} for n in sets[0][0]] if verdict == "effect" else []
    told = {
        "format": 1, "verdict": verdict, "effects": effects, "candidates": [{"set": s, "probability": p} for s, p in sets],
        "novelty": {"p_value": p_value}, "where": {"regions": []}, "gap": {}, "made_by": {"seconds": 3.0},
    }  # fmt: skip
    (root / name / "diagnosis.json").write_text(json.dumps(told))


@pytest.fixture
def sealed(tmp_path: Path, cases: dict[str, tuple[Case, Path]]) -> Path:
    """The labels of the drawn cases, and a case of Maxwell elements without a gap made from one of them."""
    (tmp_path / "labels/oracle").mkdir(parents=True)
    labels = {}
    for case, place in cases.values():
        labels[place.name] = generate.plain(case.label)
        folder.save(tmp_path / "labels/oracle" / f"{place.name}.parquet", case.oracle)
    labels["002"]["stands_for"] = ["maxwell_slip"]
    (tmp_path / "labels/labels.json").write_text(json.dumps({"split": "development", "cases": labels}))
    return tmp_path


@pytest.fixture
def few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Intervals by the bootstrap are not what is asked of here."""
    monkeypatch.setattr(statistics_of_scores, "DRAWS", 20)


@pytest.mark.usefixtures("few_draws")
def test_perfect_answers_score_one_and_wrong_ones_nothing(sealed: Path, cases: dict[str, tuple[Case, Path]]) -> None:
    for case, place in cases.values():
        truth = case.label["effects"]
        verdict = {"none": "no_gap", "mistuned": "mistuned", "unknown": "unknown"}.get(case.label["truth"], "effect")
        answered(sealed / "good", place.name, verdict, [(truth, 1.0)], 0.01 if verdict == "unknown" else 0.9)
        wrong = ["sensor_drift"] if case.label["truth"] not in ("single", "pair") else []
        answered(sealed / "bad", place.name, "effect" if wrong else "no_gap", [(wrong, 1.0)], 0.9 if verdict == "unknown" else 0.01)
    good, bad = (scores.score(sealed / "labels", sealed / which)["figures"]["all"] for which in ("good", "bad"))
    right = ("singles_exact", "family_exact", "truth_in_set", "pairs_exact", "mistuned", "unknown_recognised", "auroc", "answered")
    assert {key: good[key]["value"] for key in right} == dict.fromkeys(right, 1.0)
    assert {key: bad[key]["value"] for key in right[:-1]} == dict.fromkeys(right[:-1], 0.0)
    wrong_ones = ("false_alarms", "unknown_named", "ece")
    assert {key: good[key]["value"] for key in wrong_ones} == dict.fromkeys(wrong_ones, 0.0)
    assert {key: bad[key]["value"] for key in wrong_ones} == dict.fromkeys(wrong_ones, 1.0)
    assert good["seconds"]["value"] == 3.0
    assert good["singles_exact"]["count"] == 1  # the small one stands in its stratum alone
    text = scores.table(scores.score(sealed / "labels", sealed / "good"))
    assert "singles, family exact" in text
    assert "<= 0.05 | <= 0.10" in text


@pytest.mark.usefixtures("few_draws")
def test_a_true_statement_on_the_base_law_is_no_false_alarm_and_a_second_one_is_counted(sealed: Path, cases: dict[str, Any]) -> None:
    for case, place in cases.values():
        truth = case.label["effects"]
        answered(sealed / "said", place.name, "ambiguous", [(["maxwell_slip"] if not truth else [*truth, "sensor_drift"], 0.6), ([], 0.4)])
    judged = scores.score(sealed / "labels", sealed / "said")
    assert judged["figures"]["other"]["false_alarms"]["value"] == 0.0
    assert judged["figures"]["other"]["false_alarms_strict"]["value"] == 1.0
    assert judged["figures"]["right"]["false_alarms"]["value"] == 1.0
    assert judged["figures"]["right"]["wrong_second"]["value"] == 1.0
    assert judged["figures"]["right"]["singles_exact"]["value"] == 0.0
    assert judged["figures"]["all"]["set_size"]["value"] == 2.0


@pytest.mark.usefixtures("few_draws")
def test_a_missing_answer_is_a_wrong_one(sealed: Path) -> None:
    figures = scores.score(sealed / "labels", sealed / "nowhere")["figures"]["all"]
    assert figures["answered"]["value"] == 0.0
    assert figures["singles_exact"]["value"] == 0.0
    assert figures["false_alarms"]["value"] == 1.0


def test_the_ceiling_measures_distance_by_noise_and_nuisances_and_finds_the_truth_itself_at_no_distance(cases: dict[str, Any]) -> None:
    case = cases["ellipse single other"][0]
    truth = draw.truth_of(PLANS["ellipse single other"], "development", np.random.default_rng(case.label["seed"]))
    assert [(e.name, s) for e, s in truth.acting] == [(c["name"], c["strength"]) for c in case.label["causes"]]
    records = ceiling.Records(truth, case.label)
    gap = records.row(truth.world.clean(acting=truth.acting)) - records.row(truth.bench.plain)
    part = gap[:300]
    records.N = records.N[:300]
    records.inner = np.linalg.inv(np.eye(records.N.shape[1]) + records.N.T @ records.N)
    covariance = np.eye(300) + records.N @ records.N.T
    assert float(np.linalg.norm(records.freed(part))) == pytest.approx(float(np.sqrt(part @ np.linalg.solve(covariance, part))), rel=1e-6)
    whole = ceiling.Records(truth, case.label)
    seen = float(np.linalg.norm(whole.freed(gap)))
    assert seen > 2
    assert ceiling.left_by(whole, truth.acting[0][0], gap) < 0.1 * seen


def test_a_run_goes_on_where_it_stood(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("001", "002", "003"):
        (tmp_path / "cases" / name).mkdir(parents=True)
        (tmp_path / "cases" / name / "experiment.toml").write_text("format = 1\n")
    answered(tmp_path / "answers", "001", "no_gap", [([], 1.0)])
    (tmp_path / "answers/003.log").write_text("an error\n")
    asked: list[str] = []

    def told(case: Path, answer: Path, limit: float) -> str:
        asked.append(case.name)
        return "done"

    monkeypatch.setattr(run_diagnosis, "diagnose", told)
    given = {"cases": tmp_path / "cases", "answers": tmp_path / "answers", "jobs": 2, "limit": 5.0}
    assert run_diagnosis.run(argparse.Namespace(**given, again=False)) == 0
    assert asked == ["002"]
    run_diagnosis.run(argparse.Namespace(**given, again=True))
    assert sorted(asked) == ["002", "002", "003"]


def test_a_case_that_cannot_be_diagnosed_says_why(tmp_path: Path) -> None:
    (tmp_path / "case").mkdir()
    (tmp_path / "case/experiment.toml").write_text("format = 7\n")
    said = run_diagnosis.diagnose(tmp_path / "case", tmp_path / "answers/case", 60.0)
    assert said != "done"
    assert (tmp_path / "answers/case.log").is_file()


def test_effects_are_called_as_the_library_calls_them() -> None:
    assert {each.name for each in kernel.effects()} >= set(EFFECTS)
