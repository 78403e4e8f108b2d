"""Can the blind benchmark be trusted? The same seed gives the same bytes, nothing of the truth is in the cases, the physics is right, and
the scores of diagnoses made up to be perfect and to be bad are what they must be."""

from __future__ import annotations

import ast
import importlib
import json
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

BLIND = Path(__file__).resolve().parent / "blind"
USES_THE_MODEL = {"baselines.py", "baseline_fits.py"}  # they diagnose; the others make and judge


def module(name: str) -> ModuleType:
    """A module of the benchmark, which is no package and is run from its folder."""
    sys.path.insert(0, str(BLIND))
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(str(BLIND))


draw, ellipse, generate, law, noise, radau, rigs, scene, score, statistics = map(
    module, ("draw", "ellipse", "generate", "law", "noise", "radau", "rigs", "scene", "score", "statistics_of_scores")
)
SEED = 5
MOTIONS = {"rig": (8, {"kinematics": ["rig"]}), "all": (8, {})}  # so many cases have some of every truth; ellipses and means take minutes


def made(out: Path, count: int, **only: list[str]) -> Path:
    generate.generate(out, SEED, count, only)
    return out


@pytest.fixture(scope="module", params=["rig", pytest.param("all", marks=pytest.mark.campaign)])
def bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small benchmark with some of every truth."""
    count, only = MOTIONS[request.param]
    return made(tmp_path_factory.mktemp("blind") / "out", count, **only)


@pytest.fixture(scope="module")
def labels(bench: Path) -> dict[str, Any]:
    return dict(json.loads((bench / "labels.json").read_text(encoding="utf-8"))["cases"])


@pytest.fixture(autouse=True)
def few_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the bootstrap: no test here asks how wide it finds an interval to be."""
    monkeypatch.setattr(statistics, "DRAWS", 50)


# ---- what is made


def test_a_case_is_made_again_to_the_same_bytes(bench: Path, labels: dict[str, Any], tmp_path: Path) -> None:
    """One of those with a cause, as if a run had been broken off before it."""
    sealed = json.loads((bench / "labels.json").read_text(encoding="utf-8"))
    name = next(name for name, label in labels.items() if label["truth"] == "single")
    del sealed["cases"][name]
    (tmp_path / "labels.json").write_text(json.dumps({**sealed, "cases_to_come": 1}), encoding="utf-8")
    generate.generate(tmp_path, SEED, sealed["count"], sealed["only"])
    files = sorted(path.relative_to(bench) for path in (bench / "cases" / name).rglob("*") if path.is_file())
    assert len(files) > 1
    assert files == sorted(path.relative_to(tmp_path) for path in (tmp_path / "cases").rglob("*") if path.is_file())
    for file in (*files, Path("oracle", f"{name}.parquet")):
        assert (tmp_path / file).read_bytes() == (bench / file).read_bytes(), file
    assert json.loads((tmp_path / "labels.json").read_text(encoding="utf-8"))["cases"] == labels


@pytest.mark.campaign  # another seed, and those of which the same is not asked above
@pytest.mark.parametrize("motion", ["rig", "ellipse", "means"])
def test_the_same_seed_gives_the_same_bytes(motion: str, tmp_path: Path) -> None:
    one, two = (made(tmp_path / name, 1, kinematics=[motion], truth=["single"]) for name in ("one", "two"))
    files = sorted(path.relative_to(one) for path in one.rglob("*") if path.is_file())
    assert files == sorted(path.relative_to(two) for path in two.rglob("*") if path.is_file())
    assert [file for file in files if (one / file).read_bytes() != (two / file).read_bytes()] == []


def test_a_run_that_was_broken_off_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Broken off in its second case it ends with the bytes of a run that was not; a finished one is not written over."""
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    only = {"truth": ["none"], "kinematics": ["rig"]}
    generate.generate(whole, SEED, 3, only)
    save, calls = generate.save, []

    def stop(path: Path, table: Any) -> None:
        calls.append(path)
        if len(calls) == 2:
            raise KeyboardInterrupt
        save(path, table)

    monkeypatch.setattr(generate, "save", stop)
    with pytest.raises(KeyboardInterrupt):
        generate.generate(broken, SEED, 3, only)
    monkeypatch.undo()
    assert (broken / "cases" / "002").is_dir()
    assert not (broken / "oracle" / "002.parquet").exists()
    generate.generate(broken, SEED, 3, only)
    for path in whole.rglob("*"):
        assert path.is_dir() or path.read_bytes() == (broken / path.relative_to(whole)).read_bytes()
    with pytest.raises(SystemExit, match="finished"):
        generate.generate(broken, SEED, 3, only)
    with pytest.raises(SystemExit, match="finished"):
        generate.generate(whole, SEED + 1, 3, only)


def test_another_seed_gives_other_cases(tmp_path: Path) -> None:
    for seed in (SEED, SEED + 1):
        generate.generate(tmp_path / str(seed), seed, 1, {"truth": ["none"], "kinematics": ["rig"]})
    one, other = (tmp_path / str(seed) / "cases" / "001" / "experiment.toml" for seed in (SEED, SEED + 1))
    assert one.read_bytes() != other.read_bytes()


def test_the_generator_imports_nothing_of_the_package() -> None:
    sources = [path for path in BLIND.glob("*.py") if path.name not in USES_THE_MODEL]
    assert len(sources) > 15
    for path in sources:
        imported = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            imported |= {name.name for name in node.names} if isinstance(node, ast.Import) else set()
            imported |= {node.module or "."} if isinstance(node, ast.ImportFrom) else set()
            imported |= {"import_module"} if isinstance(node, ast.Name) and node.id in ("__import__", "import_module") else set()
        roots = {name.split(".")[0] for name in imported}
        assert not roots & {"evat", "fmu_src", "cffi", "ctypes", "subprocess", "importlib", "import_module", "runpy"}, path.name
        assert not roots & {name.removesuffix(".py") for name in USES_THE_MODEL}, path.name


def test_nothing_of_the_truth_is_in_a_case(bench: Path, labels: dict[str, Any]) -> None:
    words = re.compile(
        r"\b(truth|labels?|single|pair|mistuned|unknown|stratum|oracle|seed|wrong|right|none|nominal_gap|"
        + "|".join([*generate.CAUSES, *generate.STRANGERS, *generate.FOR_MEANS])
        + r")\b"
    )
    for name, label in labels.items():
        for path in (bench / "cases" / name).rglob("*"):
            assert not words.search(path.relative_to(bench / "cases").as_posix())
            text = path.read_bytes().decode("utf-8", "replace") if path.is_file() else ""
            if path.name == "experiment.toml":  # what the nominal model has is no secret
                assert f'title = "Record {name}"' in text
                text = re.sub(r"^effects = .*$|^\"thermal_softening\.\w+\" = .*$", "", text, flags=re.MULTILINE)
            assert not words.search(text), (path, label["truth"])
    assert sorted(path.name for path in bench.iterdir()) == ["cases", "labels.json", "oracle"]
    assert sorted(path.name for path in (bench / "cases").iterdir()) == sorted(labels)


def test_a_nominal_model_without_a_gap_is_not_given_away(labels: dict[str, Any]) -> None:
    """What a cause needs (a flat Stribeck curve, no viscous part, a temperature, a load) others have at times, too."""
    rng = np.random.default_rng(0)
    setups = [draw.setup_for("rig", (), rng, False) for _ in range(80)]
    dry = np.mean([s.world.values["sigma2"] == 0 for s in setups])
    flat = np.mean([s.world.values["F_S"] == s.world.values["F_C"] for s in setups])
    hot = np.mean([bool({"proxy_speed", "contact_temperature"} & set(s.inputs)) for s in setups])
    loaded = np.mean(["normal_load" in s.inputs for s in setups])
    assert 0.05 < dry < 0.35
    assert 0.05 < flat < 0.35
    assert 0.3 < hot < 0.8
    assert 0.2 < loaded < 0.7


def test_labels_say_what_the_table_of_scores_needs(labels: dict[str, Any]) -> None:
    truths = {label["truth"] for label in labels.values()}
    assert truths == {"none", "mistuned", "single", "pair", "unknown"}
    for label in labels.values():
        named = label["truth"] in ("single", "pair")
        assert len(label["effects"]) == {"single": 1, "pair": 2}.get(label["truth"], 0)
        assert bool(label["where"]) == named
        assert label["detectable"] == (label["seen"] > 5)
        if named:
            assert max(label["gap_over_noise"].values()) == pytest.approx(label["ratio"], rel=1e-6)
            shares = sum(region["share"] for region in label["where"])
            assert 0.8 * 0.6 < shares <= 1.0001  # 80 % of each channel but two with a fifth at most
        if label["truth"] == "mistuned":
            off = {n: v / label["values"][n] - 1 for n, v in label["nominal"].items() if v != label["values"][n]}
            assert 1 <= len(off) <= 3
            assert all(0.045 <= abs(x) <= 0.405 for x in off.values())
        if label["truth"] == "none":
            assert label["nominal"] == label["values"]


# ---- the physics of it


def test_the_integrator_agrees_with_scipy_radau() -> None:
    """A bristle that is stiff at speed and soft at reversal. Tolerance: order 3 on a grid of 1/800 of a cycle."""
    frequency, peak, values = 10.0, 0.05, {"F_C": 3.0, "F_S": 4.5, "v_s": 4e-3, "sigma0": 3e5, "sigma1": 0.0, "sigma2": 0.0}

    def slip(t: Any) -> Any:
        return peak * np.sin(2 * np.pi * frequency * t)

    times = np.linspace(0, 0.25, 251)
    own = law.friction(law.open_fields(scene.given(times, 8, {"slip_velocity": slip}, {}, None), values), law.Form())[::8]

    def rate(t: float, z: Any) -> Any:
        v = slip(t)
        return v - values["sigma0"] * abs(v) * z / (values["F_C"] + (values["F_S"] - values["F_C"]) * np.exp(-((v / values["v_s"]) ** 2)))

    theirs = solve_ivp(rate, (0, 0.25), [0.0], "Radau", t_eval=times, rtol=1e-8, atol=1e-14, max_step=1e-4)
    assert own == pytest.approx(values["sigma0"] * theirs.y[0], abs=2e-4 * 4.5)


def test_a_gate_that_is_open_changes_nothing() -> None:
    """The stepwise integration of laws that are not linear in the deflection, against the whole-record one. Tolerance: of both grids."""
    values = {"F_C": 3.0, "F_S": 4.0, "v_s": 4e-3, "sigma0": 1e5, "sigma1": 5.0, "sigma2": 2.0}
    rubbing = scene.given(np.linspace(0, 0.2, 241), 8, {"slip_velocity": lambda t: 0.02 * np.sin(2 * np.pi * 10 * t)}, {}, None)
    plain, gated = law.open_fields(rubbing, values), law.open_fields(rubbing, values)
    gated.z_gate = lambda z, v, steady: 1.0
    assert law.friction(gated, law.Form()) == pytest.approx(law.friction(plain, law.Form()), abs=1e-3 * 4)


@pytest.mark.parametrize(
    ("ratio", "entry", "exit_", "cusp"),
    [(0.05, 0.1501, 1.6208, 0.01125), (0.1, 0.2893, 1.6710, 0.04154), (0.2, 0.5459, 1.7722, 0.14532), (0.5, 1.2461, 2.0944, 0.68098)],
)
def test_the_ellipse_enters_and_leaves_where_geometry_says(ratio: float, entry: float, exit_: float, cusp: float) -> None:
    """Angles from the bottom of the path, where the nominal surface does not bind. Tolerance: the last printed digit, and the table."""
    f, a, b = 20e3, 5e-6, 4e-6
    values = {
        "vibration_frequency": f, "amplitude_x": a, "amplitude_y": b, "feed": 1e-4, "width": 1e-3, "rake_angle": 0.0,
        "chip_flow_shear_angle": 0.5, "shear_stress": 4e8, "cutting_speed": ratio * 2 * np.pi * f * a,
    }  # fmt: skip
    path = ellipse.Path(values)
    thickness = path.surfaces(3 / f)
    angle = np.linspace(-np.pi, np.pi, 40001)
    t = 1 / f + angle / (2 * np.pi * f)
    cutting = (thickness(t) > 0) & (path.approach(t) > 0)
    begin, end = angle[cutting][0], angle[cutting][-1]
    assert -begin == pytest.approx(entry, abs=4e-4)
    assert end == pytest.approx(exit_, abs=4e-4)
    assert 1 - np.cos(entry) == pytest.approx(cusp, abs=2e-5)
    assert path.place(np.array([1 / f + begin / (2 * np.pi * f)]))[1][0] + b == pytest.approx(cusp * b, abs=2e-4 * b)


def test_a_case_without_causes_holds_its_noise_and_nothing_else(tmp_path: Path) -> None:
    """Residual of the recorded against the noise-free: the rms that the label states (10 %: finite records, and the scatter of trials),
    no mean beyond the scatter of zeros, and the same in repeats."""
    out = made(tmp_path / "quiet", 3, truth=["none"], kinematics=["rig"])
    for name, label in json.loads((out / "labels.json").read_text(encoding="utf-8"))["cases"].items():
        if label["noise"]["outliers"] or label["noise"]["tail"]:
            continue
        (channel,) = label["channels"]
        assert label["oracle_rms"][channel] == pytest.approx(label["noise"]["rms"][channel], rel=0.25)
        assert label["oracle_rms"][channel] > 0.9 * label["noise"]["rms"][channel], name


def test_the_noise_has_the_colour_it_says() -> None:
    """An autoregression's first autocorrelation is (a + b)/(1 + a b); of 200 000 samples it is known to 0.01."""
    coloured = noise.Noise({"F": 2.0}, (0.7, 0.2), {"gain": 0.0, "zero F": 0.0, "delay": 0.0})
    x = coloured.draw(np.random.default_rng(1), 200_000)
    assert np.std(x) == pytest.approx(1, abs=0.02)
    assert np.mean(x[1:] * x[:-1]) / np.var(x) == pytest.approx(0.9 / 1.14, abs=0.01)
    assert coloured.memory == pytest.approx(float(np.sum([coloured._correlation(300)[1:]])), rel=1e-3)


# ---- the judging of it


def perfect(label: dict[str, Any]) -> dict[str, Any]:
    names, truth = label["effects"], label["truth"]
    verdict = {"none": "no_gap", "mistuned": "mistuned", "unknown": "unknown"}.get(truth, "effect")
    gap = {
        n: {"recalibrated": float(np.hypot(label["gap_rms"][n], label["oracle_rms"][n])), "corrected": label["oracle_rms"][n],
            "noise_floor": label["oracle_rms"][n], "nominal": 1.0} for n in label["channels"]
    }  # fmt: skip
    return {
        "format": 1,
        "verdict": verdict,
        "effects": [{"name": n, "probability": 1.0, "parameters": {}, "not_separable_from": []} for n in names],
        "candidates": [{"set": names, "probability": 1.0}],
        "novelty": {"p_value": 0.001 if truth == "unknown" else 0.6, "unexplained_share": 0.0},
        "where": {"channels": {}, "regions": label["where"], "trials": {}},
        "gap": {"unit": "N rms", "channels": gap, "closed_share": {"value": 1.0}},
        "made_by": {"seconds": 3.0},
    }


def bad(label: dict[str, Any]) -> dict[str, Any]:
    """Names an effect that is not there where there is none or another, and is sure of it, everywhere but in the right place."""
    answer = perfect(label)
    name = "sensor_delay" if "sensor_delay" not in label["effects"] else "stribeck"
    known = label["truth"] in ("single", "pair")
    return answer | {
        "verdict": "effect", "effects": [{"name": name, "probability": 1.0}], "candidates": [{"set": [name], "probability": 1.0}],
        "novelty": {"p_value": 0.001 if known else 0.6}, "where": {"regions": []}, "made_by": {"seconds": 90.0},
    }  # fmt: skip


def judged(bench: Path, labels: dict[str, Any], answer: Any, folder: Path) -> dict[str, Any]:
    for name, label in labels.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "diagnosis.json").write_text(json.dumps(answer(label)), encoding="utf-8")
    return dict(score.score(bench, folder))


def value(scores: dict[str, Any], name: str, group: str = "all") -> float:
    return float(scores["figures"][group][name]["value"])


def test_a_perfect_diagnosis_scores_all_there_is(bench: Path, labels: dict[str, Any], tmp_path: Path) -> None:
    scores = judged(bench, labels, perfect, tmp_path)
    ones = ("top-1, detectable single effect", "truth in the 90 % set", "size of the 90 % set", "pairs exact", "mistuned recognised",
            "open-set AUROC", "location F1", "location IoU", "closure against an oracle", "unknown recognised", "answered")  # fmt: skip
    assert {name: value(scores, name) for name in ones} == dict.fromkeys(ones, pytest.approx(1.0, abs=1e-9))
    zeros = ("false alarms", "unknown named as known", "calibration error (ECE)")
    assert {name: value(scores, name) for name in zeros} == dict.fromkeys(zeros, pytest.approx(0.0, abs=1e-9))
    assert value(scores, "seconds, median") == 3.0
    assert value(scores, "reported gap over true gap") == pytest.approx(1.0, abs=1e-6)
    assert "top-1" in score.table(scores)


def test_a_bad_diagnosis_scores_nothing(bench: Path, labels: dict[str, Any], tmp_path: Path) -> None:
    scores = judged(bench, labels, bad, tmp_path)
    zeros = ("top-1, detectable single effect", "truth in the 90 % set", "pairs exact", "mistuned recognised", "open-set AUROC",
             "location F1", "location IoU", "unknown recognised")  # fmt: skip
    assert {name: value(scores, name) for name in zeros} == dict.fromkeys(zeros, pytest.approx(0.0, abs=1e-9))
    ones = ("false alarms", "unknown named as known", "calibration error (ECE)")
    assert {name: value(scores, name) for name in ones} == dict.fromkeys(ones, pytest.approx(1.0, abs=1e-9))


def test_no_answer_or_a_broken_one_counts_as_wrong(bench: Path, labels: dict[str, Any], tmp_path: Path) -> None:
    (tmp_path / "001").mkdir()
    (tmp_path / "001" / "diagnosis.json").write_text('{"format": 1, "verdict": "sure"}', encoding="utf-8")
    scores = score.score(bench, tmp_path)
    assert len(scores["failed"]) == len(labels)
    assert "sure" in scores["failed"]["001"]
    assert value(scores, "answered") == 0
    assert value(scores, "top-1, detectable single effect") == 0
    assert value(scores, "false alarms") == 1


def test_half_a_place_overlaps_by_a_half(bench: Path, labels: dict[str, Any]) -> None:
    """All samples of a channel told where the truth is a box of share p of them: IoU = p, F1 = 2 p/(1 + p)."""
    location, answers = module("location"), module("answers")
    name, label = next((n, c) for n, c in labels.items() if c["truth"] == "single" and c["kinematics"] != "means")
    channel = label["channels"][0]
    label = label | {"name": name, "channels": [channel], "places": {channel: [[{"channel": channel, "box": {"time": [0, 1e9]}}]]}}
    samples = location._samples(bench / "oracle" / f"{name}.parquet")
    middle = float(np.median(samples["at time"]))
    p = float(np.mean(samples["at time"] <= middle))
    told = answers.Answer(regions=({"channel": channel, "box": {"time": [0, middle]}},))
    assert location.overlap(label, told, bench) == pytest.approx((2 * p / (1 + p), p), abs=1e-9)


def test_intervals_are_the_textbook_ones() -> None:
    """Wilson's 90 % interval of 8 in 10, and the area under a curve of known ranks."""
    share = statistics.share_of([True] * 8 + [False] * 2)
    z = 1.6448536
    assert (share.low + share.high) / 2 == pytest.approx((0.8 + z * z / 20) / (1 + z * z / 10), abs=1e-6)
    assert share.high - share.low == pytest.approx(2 * z / (1 + z * z / 10) * np.sqrt(0.8 * 0.2 / 10 + z * z / 400), abs=1e-6)
    assert statistics.area_under_curve([3, 2], [1, 2]).value == pytest.approx(3.5 / 4)
    assert statistics.calibration_error([0.95] * 4, [True, True, True, False]).value == pytest.approx(0.2)


@pytest.mark.campaign
def test_the_baselines_answer_in_the_format(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a library of a few effects: the baselines fit each of them."""
    baselines = module("baselines")
    model = baselines.ContactModel(threads=1)
    model.effects = tuple(effect for effect in model.effects if effect.name.startswith(("sensor_", "edge_", "direction_")))
    assert len(model.effects) > 4
    monkeypatch.setattr(baselines, "ContactModel", lambda threads: model)
    out = tmp_path / "out"
    generate.generate(out, SEED, 1, {"truth": ["single"], "kinematics": ["means"], "stratum": ["high"]})
    assert baselines.main([str(out), str(tmp_path / "answers")]) == 0
    for method in baselines.METHODS:
        scores = score.score(out, tmp_path / "answers" / method)
        assert not scores["failed"]
        assert value(scores, "answered") == 1
