"""Do the files of a diagnosis hold what was found, appear whole or not at all, and correct the FMU?"""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnosed import EFFECT, MODEL, NOMINAL, SIZE, diagnosed, experiment
from evat import parameter_sets
from evat.constants import CONSTANTS
from evat.experiment import Experiment, Means
from evat.experiment.write import write_experiment
from evat.gap import _named
from evat.gap.advise import Advice
from evat.gap.answer import Diagnosis
from evat.gap.next_step import RECORDED
from evat.gap.report import OutputError, corrected, explain, fmu_run, output, sentence, write_diagnosis
from evat.gap.report.summary import headline
from evat.gap.search.compare import Comparison
from evat.gap.set_up import SetUpError
from evat.gap.verdict.credibility import shifted
from evat.inference.band_whitening import BandWhitening
from evat.inference.hypothesis import Hypothesis
from evat.inference.noise.estimate import estimate_noise
from evat.inference.prediction import Prediction
from evat.model import ParameterError, Run
from evat.models.contact import ContactModel
from evat.models.drive import drive
from evat.models.fmu import FmuModel
from evat.native import kernel
from typer.testing import CliRunner

FILES = {"diagnosis.json", "report.html", "corrected.ssv"}
NUMBER, TEXT, FLAG, NONE = (int, float), (str,), (bool,), (type(None),)
# The format of diagnosis.json as other programs read it; a name in <> stands for any.
CONTRACT: dict[str, Any] = {
    "format": (int,),
    "verdict": TEXT,
    "effects": [{"name": TEXT, "probability": NUMBER, "parameters": {"<>": {"value": NUMBER, "sd": NUMBER, "unit": TEXT}},
                 "not_separable_from": [TEXT]}],
    "candidates": [{"set": [TEXT], "probability": NUMBER}],
    "gates": [{"name": TEXT, "quantity": TEXT, "value": NUMBER, "wanted": TEXT, "threshold": NUMBER, "passed": FLAG, "consequence": TEXT,
               "moved": FLAG}],
    "novelty": {"p_value": NUMBER, "unexplained_share": NUMBER},
    "recalibration": {"parameters": {"<>": {"nominal": NUMBER, "value": NUMBER, "sd": NUMBER}}, "explains_share": NUMBER,
                      "with_effects": {"<>": {"value": NUMBER, "sd": NUMBER}}, "closed_share": {"value": NUMBER, "ci90": [NUMBER]}},
    "setup": {"<>": {"<>": {"value": NUMBER, "sd": NUMBER, "unit": TEXT}}},
    "small_effect": (type(None),),  # of an effect as large as this; the other form stands in test_small_effect
    "families": [{"name": TEXT, "probability": NUMBER}],
    "where": {"channels": {"<>": NUMBER},
              "regions": [{"channel": TEXT, "box": {"<>": [NUMBER]}, "share": NUMBER}],
              "trials": {"<>": NUMBER}},
    "gap": {
        "unit": TEXT,
        "channels": {"<>": {"nominal": NUMBER, "recalibrated": NUMBER, "corrected": NUMBER, "noise_floor": NUMBER}},
        "closed_share": {"value": NUMBER, "ci90": [NUMBER]},
        "held_out_conditions": [TEXT],
        "closed_share_where_fitted": {"value": NONE, "ci90": [NONE]},  # there are conditions to leave out
        "values_alone": {"channels": {"<>": {"nominal": NUMBER, "recalibrated": NUMBER, "corrected": NUMBER}}, "closed_share": NUMBER},
        "values_with_set_up": {
            "channels": {"<>": {"nominal": NUMBER, "recalibrated": NUMBER, "corrected": NUMBER}},
            "closed_share": NUMBER,
        },
    },
    "cannot_tell": [TEXT],
    "next_step": TEXT,
    "next_experiment": NONE,  # the effect is sure; the other form stands in test_an_experiment_is_advised_where_the_words_do
    "made_by": {"version": TEXT, "model": TEXT, "data": TEXT, "seconds": NUMBER},
}  # fmt: skip


def _agrees(document: Any, wanted: Any, at: str = "") -> None:
    if isinstance(wanted, dict):
        assert isinstance(document, dict), at
        assert "<>" in wanted or set(document) == set(wanted), at
        for name, part in document.items():
            _agrees(part, wanted.get("<>", wanted.get(name)), f"{at}.{name}")
    elif isinstance(wanted, list):
        assert isinstance(document, list), at
        for part in document:
            _agrees(part, wanted[0], f"{at}[]")
    else:
        assert isinstance(document, wanted), f"{at}: {document!r}"
        assert isinstance(document, bool) == (wanted == FLAG), at


@pytest.fixture(scope="module")
def outcome() -> tuple[Diagnosis, Comparison]:
    answer, comparison = diagnosed()
    return replace(answer, made_by={**answer.made_by, "seconds": 1.5}), comparison


@pytest.fixture(scope="module")
def written(outcome: tuple[Diagnosis, Comparison], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its files, which no test changes."""
    folder = tmp_path_factory.mktemp("written") / "out"
    paths = write_diagnosis(*outcome, folder)
    assert {path.name for path in paths} == FILES == {path.name for path in folder.iterdir()}
    return folder


@pytest.fixture
def plain_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page without its pictures, where the folder is looked at and not what stands in it."""
    monkeypatch.setattr(output, "page", lambda answer, *_: f"<html>{answer.verdict}</html>")


def test_the_json_is_as_the_format_says(written: Path) -> None:
    """And says what was simulated: the asymmetry within four of its standard deviations and a tenth, closing nearly all."""
    text = (written / "diagnosis.json").read_text(encoding="utf-8")
    read = json.loads(text, parse_constant=lambda word: pytest.fail(f"{word} is no JSON"))
    _agrees(read, CONTRACT)
    assert read["next_step"] == "use_corrected"
    assert read["format"] == 1
    assert read["verdict"] == "effect"
    (effect,) = read["effects"]
    assert effect["name"] == EFFECT
    size = effect["parameters"]["a"]
    assert abs(size["value"] - SIZE) < 4 * size["sd"] + 0.1 * SIZE
    assert 0.9 < read["gap"]["closed_share"]["value"] < 1.1
    assert sum(read["where"]["channels"].values()) == pytest.approx(1.0, abs=1e-5)
    assert sum(each["probability"] for each in read["candidates"]) <= 1 + 1e-5


def test_the_same_answer_gives_the_same_bytes(outcome: tuple[Diagnosis, Comparison], tmp_path: Path, fmi2_fmu: Path) -> None:
    for name in ("one", "two"):
        write_diagnosis(*outcome, tmp_path / name, fmu=fmi2_fmu)
    for file in FILES:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes()


@pytest.mark.usefixtures("plain_page")
@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError, RuntimeError])
@pytest.mark.parametrize("before", [False, True])
def test_an_interrupted_diagnosis_leaves_what_was_there(
    outcome: tuple[Diagnosis, Comparison], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException], before: bool
) -> None:
    out = tmp_path / "out"
    if before:
        write_diagnosis(*outcome, out)
    there = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}

    def fails(*_: object) -> str:
        raise error("stopped half-way")

    monkeypatch.setattr(output, "page", fails)
    with pytest.raises(OutputError if error is OSError else error):
        write_diagnosis(replace(outcome[0], verdict="unknown"), outcome[1], out)
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == there
    assert [path.name for path in tmp_path.iterdir()] == (["out"] if before else [])


@pytest.mark.usefixtures("plain_page")
@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_interrupted_between_the_two_renames(
    outcome: tuple[Diagnosis, Comparison], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: type[BaseException]
) -> None:
    out = tmp_path / "out"
    write_diagnosis(*outcome, out)
    there = (out / "diagnosis.json").read_bytes()
    rename, calls = output.os.rename, list[object]()

    def fails_once(*paths: Any) -> None:
        calls.append(paths)
        if len(calls) == 2:
            raise error("stopped")
        rename(*paths)

    monkeypatch.setattr(output.os, "rename", fails_once)
    with pytest.raises(OutputError if error is OSError else error):
        write_diagnosis(replace(outcome[0], verdict="unknown"), outcome[1], out)
    assert (out / "diagnosis.json").read_bytes() == there
    assert {path.name for path in tmp_path.iterdir()} == {"out"}


@pytest.mark.usefixtures("plain_page")
def test_an_earlier_diagnosis_is_replaced_whole(outcome: tuple[Diagnosis, Comparison], tmp_path: Path) -> None:
    write_diagnosis(*outcome, tmp_path / "out")
    write_diagnosis(replace(outcome[0], verdict="unknown"), outcome[1], tmp_path / "out")
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))["verdict"] == "unknown"
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


@pytest.mark.usefixtures("plain_page")
def test_what_is_no_diagnosis_is_left_alone(outcome: tuple[Diagnosis, Comparison], tmp_path: Path) -> None:
    """A folder of somebody else's, a diagnosis that somebody has added to, a file, a link; an empty folder is free."""
    (tmp_path / "theirs").mkdir()
    (tmp_path / "theirs" / "thesis.txt").write_text("years", encoding="utf-8")
    (tmp_path / "theirs" / "diagnosis.json").write_text("{}", encoding="utf-8")
    write_diagnosis(*outcome, tmp_path / "ours")
    (tmp_path / "ours" / "notes.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "file").write_text("a file", encoding="utf-8")
    for name, word in (("theirs", "thesis.txt"), ("ours", "notes.txt"), ("file", "no folder")):
        with pytest.raises(OutputError, match=word):
            write_diagnosis(*outcome, tmp_path / name)
    assert (tmp_path / "theirs" / "thesis.txt").read_text(encoding="utf-8") == "years"
    assert (tmp_path / "file").read_text(encoding="utf-8") == "a file"
    (tmp_path / "empty").mkdir()
    write_diagnosis(*outcome, tmp_path / "empty")


@pytest.mark.usefixtures("plain_page")
def test_a_link_is_not_followed(outcome: tuple[Diagnosis, Comparison], tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    try:
        (tmp_path / "link").symlink_to(tmp_path / "real")
    except OSError:
        pytest.skip("links cannot be made here")
    with pytest.raises(OutputError, match="no folder"):
        write_diagnosis(*outcome, tmp_path / "link")


def test_the_set_switches_the_effect_on_in_the_fmu(outcome: tuple[Diagnosis, Comparison], written: Path, fmi2_fmu: Path) -> None:
    """The FMU with corrected.ssv gives what the model has without set-up errors, to 1e-9 of the force: the same code, a millionth of what
    the effect changes. Without the switch it does not."""
    _, comparison = outcome
    read = parameter_sets.load(written / "corrected.ssv")
    assert read.effects == (EFFECT,)
    chosen = comparison.models[Hypothesis((EFFECT,))]
    assert read.values[f"{EFFECT}.a"] == chosen.values[f"{EFFECT}.a"]
    assert "standard deviation" in read.sources[f"{EFFECT}.a"]
    told = json.loads((written / "diagnosis.json").read_text(encoding="utf-8"))["recalibration"]
    with_effects = {name: own["value"] for name, own in told["with_effects"].items()}
    assert with_effects == pytest.approx({name: float(read.values[name]) for name in told["parameters"]}, rel=1e-5)
    assert "nominal 9 N" in read.sources["F_C"]
    assert any("hash of no file" in note for note in read.notes)
    assert any(
        note.startswith("With the set-up put right corrected.ssv closes ") for note in read.notes
    )  # beside the share of the whole fit
    trial = comparison.prediction.experiment.trials[0]
    run = Run(trial.times, trial.inputs, ("measured_friction_force",))
    plain = comparison.prediction.linearise(())
    wanted = plain.one(comparison.prediction.of_model_alone(chosen.values), chosen.on)[plain.segments[0].at]
    size = float(np.max(np.abs(wanted)))
    force = drive(fmi2_fmu, run, {**kernel.by_choice(dict(read.values)), EFFECT: True})["measured_friction_force"]
    assert np.max(np.abs(force - wanted)) < 1e-9 * size
    without = drive(fmi2_fmu, run, kernel.by_choice(dict(read.values)))["measured_friction_force"]
    assert 0.5 * SIZE < np.max(np.abs(without - wanted)) / size < 2 * SIZE


def test_without_an_effect_the_set_is_the_recalibrated_model(outcome: tuple[Diagnosis, Comparison], tmp_path: Path) -> None:
    answer, comparison = outcome
    judgement = replace(answer.judgement, chosen=Hypothesis(), verdict="mistuned")
    write_diagnosis(replace(answer, verdict="mistuned", effects=(), judgement=judgement), comparison, tmp_path / "out")
    read = parameter_sets.load(tmp_path / "out" / "corrected.ssv")
    assert read.effects == ()
    assert read.values["F_C"] == comparison.recalibrated.values["F_C"] != NOMINAL["F_C"]


def test_the_after_figures_are_the_fmus(outcome: tuple[Diagnosis, Comparison], written: Path, fmi2_fmu: Path) -> None:
    """rms of measured less FMU, as this set-up shows it, taken here from the FMU's own run; and its lines are what the report draws."""
    answer, comparison = outcome
    gain, zero, clock, drift = (errors[0] for errors in answer.recalibration.setup["friction_force"].values())
    (off,) = (error[0] for error in answer.recalibration.setup["slip_velocity"].values())
    ssv, chosen = written / "corrected.ssv", comparison.models[Hypothesis((EFFECT,))]
    run = fmu_run.run_fmu(fmi2_fmu, ssv, comparison, chosen, answer.closure.held_out_conditions)
    assert run.conditions == answer.closure.held_out_conditions
    # rates of inputs that a host gives differ in their last digits, and with them may a step of the solver: a hundredth of its tolerance
    assert run.difference < 1e-2 * float(comparison.prediction.nominal["relative_tolerance"])
    read, squares, count = parameter_sets.load(ssv), 0.0, 0
    for trial in comparison.prediction.experiment.trials:
        if trial.condition in run.conditions:
            slip = {"slip_velocity": trial.inputs["slip_velocity"] - off}
            force = drive(fmi2_fmu, Run(trial.times, slip, ("friction_force",)), {**kernel.by_choice(dict(read.values)), EFFECT: True})
            late = clock + drift * (trial.times - trial.times[0])
            shown = (1 + gain) * np.interp(trial.times - late, trial.times, force["friction_force"]) + zero
            squares += float(np.sum((trial.outputs["friction_force"] - shown) ** 2))
            count += trial.times.size
    assert run.rms["friction_force"]["corrected"] == pytest.approx(math.sqrt(squares / count), rel=1e-9)
    assert run.rms["friction_force"]["nominal"] > 10 * run.rms["friction_force"]["corrected"]


def test_what_corrected_ssv_reaches_by_itself_is_what_its_user_gets(
    outcome: tuple[Diagnosis, Comparison], written: Path, fmi2_fmu: Path
) -> None:
    """The page said that the FMU "with the values of corrected.ssv" leaves what it leaves with gain and zero of the set-up, and a run with
    that file left more. Run here with the file and nothing else, by the model and by the FMU."""
    answer, comparison = outcome
    read = parameter_sets.load(written / "corrected.ssv")
    told = json.loads((written / "diagnosis.json").read_text(encoding="utf-8"))["gap"]["values_alone"]
    left: dict[str, list[Any]] = {"nominal": [], "corrected": []}
    for trial in comparison.prediction.experiment.trials:
        if trial.condition not in answer.closure.held_out_conditions:
            continue
        run, nominal = Run(trial.times, trial.inputs, ("measured_friction_force",)), comparison.prediction.nominal
        for name, on, values in (("nominal", (), nominal), ("corrected", read.effects, kernel.by_choice(dict(read.values)))):
            force = MODEL.simulate(run, on, values)["measured_friction_force"]
            left[name].append(trial.outputs["friction_force"] - force)
    row, floor = told["channels"]["friction_force"], answer.closure.rms["friction_force"]["noise_floor"]
    for name, residuals in left.items():
        assert row[name] == pytest.approx(float(np.sqrt(np.mean(np.concatenate(residuals) ** 2))), rel=1e-5)
    share = (row["recalibrated"] ** 2 - row["corrected"] ** 2) / (row["recalibrated"] ** 2 - floor**2)
    assert told["closed_share"] == pytest.approx(share, rel=1e-3)
    chosen = comparison.models[Hypothesis((EFFECT,))]
    ran = fmu_run.run_fmu(fmi2_fmu, written / "corrected.ssv", comparison, chosen, answer.closure.held_out_conditions)
    assert ran.rms["friction_force"]["alone"] == pytest.approx(row["corrected"], rel=1e-5)
    # it is another figure than that with the set-up
    assert abs(ran.rms["friction_force"]["alone"] / ran.rms["friction_force"]["corrected"] - 1) > 1e-3


def test_an_fmu_that_differs_is_told_of(
    outcome: tuple[Diagnosis, Comparison], written: Path, fmi2_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer, comparison = outcome
    simulate = FmuModel.simulate

    def wrong(self: FmuModel, run: Run, on: Any, values: Any) -> Any:
        trace = simulate(self, run, on, values)
        return replace(trace, columns={name: column + 1.0 for name, column in trace.columns.items()})

    monkeypatch.setattr(FmuModel, "simulate", wrong)
    ssv, chosen = written / "corrected.ssv", comparison.models[Hypothesis((EFFECT,))]
    run = fmu_run.run_fmu(fmi2_fmu, ssv, comparison, chosen, answer.closure.held_out_conditions)
    level = comparison.whitening.levels["friction_force"]
    shown = 1 + float(chosen.values["setup.friction_force.gain"])  # of 1 N
    assert run.difference == pytest.approx(max(shown, 1.0) / level, rel=1e-6)  # the larger of the runs with the set-up and without it
    held = [s.at for s in comparison.prediction.segments if s.condition in answer.closure.held_out_conditions]
    forms = comparison.prediction.form_names  # which no FMU has
    exact = comparison.prediction.linearise(()).one({name: value for name, value in chosen.values.items() if name not in forms}, chosen.on)
    assert all(np.allclose(run.predicted[at] - exact[at], shown) for at in held)


def test_long_records_are_cut_for_the_fmu(
    outcome: tuple[Diagnosis, Comparison], written: Path, fmi2_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, comparison = outcome
    followed, simulate = list[int](), FmuModel.simulate

    def counted(self: FmuModel, run: Run, on: Any, values: Any) -> Any:
        followed.append(run.times.size)
        return simulate(self, run, on, values)

    monkeypatch.setattr(FmuModel, "simulate", counted)
    ssv, chosen = written / "corrected.ssv", comparison.models[Hypothesis((EFFECT,))]
    with CONSTANTS.replaced(fmu_samples=100):
        run = fmu_run.run_fmu(fmi2_fmu, ssv, comparison, chosen, ())
    assert (run.samples, run.runs, run.conditions) == (100, 1, ("slow",))
    assert followed == [100, 100]  # as the set-up shows it, and with the values alone
    assert run.left_out == ("middle", "fast", "fastest")
    # rates of inputs that a host gives differ in their last digits, and with them may a step of the solver: a hundredth of its tolerance
    assert run.difference < 1e-2 * float(comparison.prediction.nominal["relative_tolerance"])


def test_means_run_through_the_fmu(
    outcome: tuple[Diagnosis, Comparison], tmp_path: Path, fmi2_fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An experiment of averages alone: the FMU is asked for them, once for each row, and gives the library's numbers."""
    answer, comparison = outcome
    values = {"cutting_speed": np.array([0.2, 0.4, 0.6])}
    nominal = {**NOMINAL, "kinematics": "internal"}
    outputs = {"mean_feed_force": np.array([3.0, 5.5, 9.0])}
    base = comparison.prediction.experiment
    means = Means("means.csv", ("a", "b", "c"), values, outputs, {})
    whole = Prediction(MODEL, replace(base, trials=(), means=means, nominal=replace(base.nominal, values=nominal)))
    predicted = whole.one()
    noise = estimate_noise(whole, predicted)
    fit = replace(comparison.nominal, predicted=predicted)
    here = replace(
        comparison, prediction=whole, noise=noise, whitening=BandWhitening(whole, noise, predicted), nominal=fit, recalibrated=fit
    )
    judgement = replace(answer.judgement, chosen=Hypothesis())
    ssv = corrected.write(replace(answer, effects=(), judgement=judgement), here, tmp_path)
    calls, simulate = list[Run](), FmuModel.simulate

    def counted(self: FmuModel, run: Run, on: Any, values: Any) -> Any:
        calls.append(run)
        return simulate(self, run, on, values)

    monkeypatch.setattr(FmuModel, "simulate", counted)
    run = fmu_run.run_fmu(fmi2_fmu, ssv, here, fit, ())
    assert run.runs == 3
    assert len(calls) == 2 * run.runs  # as the set-up shows them, and with the values alone
    # rates of inputs that a host gives differ in their last digits, and with them may a step of the solver: a hundredth of its tolerance
    assert run.difference < 1e-2 * float(comparison.prediction.nominal["relative_tolerance"])


def test_why_an_effect_was_not_chosen(outcome: tuple[Diagnosis, Comparison]) -> None:
    answer, comparison = outcome
    chosen = explain(comparison, answer, EFFECT)
    assert "Chosen: probability" in chosen
    assert "number 1 of" in chosen
    silent, unfed = comparison.silent[0], next(iter(comparison.unfed))
    assert "changes nothing" in explain(comparison, answer, silent)
    assert comparison.unfed[unfed][0] in explain(comparison, answer, unfed)
    assert "It was not tried: it happens with internal or combined" in explain(comparison, answer, "amplitude_loss")
    other = next(str(on) for on in comparison.rough if len(on) == 1 and EFFECT not in on and not on.law)
    text = explain(comparison, answer, other)
    assert "Not chosen: probability" in text
    assert f"beside {EFFECT}" in text
    assert EFFECT in text.splitlines()[2]
    idle = replace(comparison, audit=replace(comparison.audit, idle={other: ("proxy_speed",)}))
    assert "It was not tried: proxy_speed does not vary" in explain(idle, answer, other)
    with pytest.raises(ParameterError, match="no effect 'warp_drive'"):
        explain(comparison, answer, "warp_drive")


def test_the_smallest_amplitude_that_would_show(outcome: tuple[Diagnosis, Comparison]) -> None:
    """Three of the standard deviations that the fit with the effect has, but for what the gap that is there adds to the doubt without it:
    not less than half of it, nor more than the effect that was found so clearly."""
    from evat.gap.report.explanation import smallest_amplitudes

    _, comparison = outcome
    effect = next(each for each in ContactModel().effects if each.name == EFFECT)
    fit = comparison.models[Hypothesis((EFFECT,))]
    smallest = smallest_amplitudes(comparison, comparison.recalibrated, effect)[f"{EFFECT}.a"]
    assert 0.5 * 3 * fit.sd[f"{EFFECT}.a"] < smallest < SIZE
    # what a nominal parameter can imitate has to be larger to show than if that parameter were known exactly
    imitated = next(each for each in ContactModel().effects if each.name == "viscous_friction")
    base = comparison.recalibrated
    exact = replace(base, parameters=(), point=np.empty(0), slopes=np.empty((base.predicted.size, 0)), fixed=base.values)
    free, known = (smallest_amplitudes(comparison, fit, imitated)[imitated.variables[0].name] for fit in (base, exact))
    assert 2 < free / known < 1e4


def test_each_verdict_is_a_sentence(outcome: tuple[Diagnosis, Comparison]) -> None:
    answer, _ = outcome
    assert sentence(answer).startswith(f"The gap is caused by {EFFECT} (probability above 99 %); on conditions left out of the fit")
    said = {verdict: sentence(replace(answer, verdict=verdict)) for verdict in ("no_gap", "mistuned", "unknown", "cannot_tell")}
    assert len(set(said.values())) == 4
    twins = replace(answer.judgement, likely=(Hypothesis((EFFECT,)), Hypothesis(("sensor_offset", "run_out"))))
    assert f"{EFFECT}; run_out + sensor_offset." in sentence(replace(answer, verdict="ambiguous", judgement=twins))
    more = replace(answer.judgement, likely=tuple(Hypothesis((EFFECT, *more)) for more in ((), ("run_out",), ("edge_force",))))
    said_more = sentence(replace(answer, verdict="ambiguous", judgement=more))
    assert said_more.startswith(f"The gap is caused by {EFFECT}, and perhaps also by one of these")
    assert said_more.endswith(": run_out; edge_force.")
    more_than_all = sentence(replace(answer, closure=replace(answer.closure, closed_share=1.153)))
    assert "closes 115 % of what recalibration leaves" in more_than_all
    nothing = replace(answer.closure, closed_share=-0.2)
    assert "closes nothing" in sentence(replace(answer, closure=nothing))


def test_a_parameter_that_changes_nothing_measured_does_not_appear(outcome: tuple[Diagnosis, Comparison]) -> None:
    """The gain of a channel that nobody recorded was told with its prior: 1 +- 1.2."""
    answer, comparison = outcome
    on = answer.judgement.chosen
    best = comparison.models[on]
    acts = np.array([p.name != f"{EFFECT}.a" for p in best.parameters])
    idle = replace(comparison, models={**comparison.models, on: replace(best, slopes=best.slopes * acts)})
    shown, hidden = (_named(each, answer.judgement)[0].parameters for each in (comparison, idle))
    assert (set(shown) - set(hidden), set(hidden) - set(shown)) == ({"a"}, set())


def test_what_is_likelier_than_the_rest_and_not_alone_is_called_likely(outcome: tuple[Diagnosis, Comparison]) -> None:
    """It was called the named cause, in green, above the words that the data cannot tell it from another."""
    answer, comparison = outcome
    assert headline(answer, comparison).status == "cause named"
    on, other, both = Hypothesis((EFFECT,)), Hypothesis(("sensor_offset",)), Hypothesis((EFFECT, "run_out"))
    judged = replace(answer.judgement, probabilities={on: 0.56, other: 0.34, both: 0.09}, likely=(on, other))
    open_ = replace(answer, judgement=judged)
    said = headline(open_, comparison)
    assert (said.status, said.tone) == ("likely cause", "note")
    assert sentence(open_, share=False) == (
        f"The gap is most likely caused by {EFFECT} (probability 65 %), if not by sensor_offset (34 %)."
    )
    nan = float("nan")
    seen = replace(
        answer.closure, closed_share=nan, interval=(nan, nan), held_out_conditions=(), closed_share_where_fitted=(0.93, (0.9, 0.96))
    )
    advised = replace(open_, advice=Advice("b", {"slip_velocity": 0.01}, (on, other), 0.62), closure=seen)
    fewer = "with fewer than 3 conditions none can be held out of the fits"
    said = headline(advised, comparison)
    assert said.share == "93 %"
    assert said.share_of == (
        "of what recalibration leaves above the noise is closed by the fit, on the conditions that it was fitted to "
        f"(90 % interval 90 % to 96 %); {fewer}"
    )
    less = headline(replace(advised, closure=replace(seen, closed_share_where_fitted=(1.06, (1.04, 1.07)))), comparison)
    beyond = "above 100 % less is left than the noise was estimated at, by chance or by a correction that goes too far"
    assert less.share == "106 %"  # as diagnosis.json has it
    assert less.share_of.endswith(f"(90 % interval 104 % to 107 %; {beyond}); {fewer}")
    few = headline(replace(advised, closure=replace(seen, closed_share_where_fitted=(0.93, (nan, nan)))), comparison)
    assert few.share_of.endswith(f"(without an interval: 3 recordings tell one); {fewer}")
    # No green badge above the words that a nominal value is not credible.
    far = replace(comparison.models[on], point=np.where(np.arange(comparison.models[on].point.size) == 0, 9.0, comparison.models[on].point))
    doubted = headline(replace(answer, shifted=shifted(comparison, far)), comparison)
    assert (doubted.status, doubted.tone) == ("cause named", "attention")
    assert "is not credible" in doubted.first[0]
    said = headline(advised, comparison).next
    assert said.endswith(f" rms: with a probability of 62 % that tells {EFFECT} from sensor_offset.")
    # The next step is to tell them apart, also where the correction holds on conditions left out.
    held = headline(replace(advised, closure=answer.closure), comparison)
    assert held.next == said
    # Where the effect acts in all that is likely, it is named.
    beside = replace(answer, judgement=replace(judged, likely=(on, both)))
    assert headline(beside, comparison).status == "cause named"


@pytest.mark.parametrize(("left", "told"), [(0.29, True), (0.08, False)])
def test_what_recalibration_leaves_is_told_where_it_is_far_more_than_noise(
    outcome: tuple[Diagnosis, Comparison], left: float, told: bool
) -> None:
    """ "Only mis-tuned", with short peaks of several times the noise that repeat, which a mean square hardly shows."""
    answer, _ = outcome
    (channel,) = answer.closure.rms
    rms = {channel: {"nominal": 1.0, "recalibrated": left, "corrected": left, "noise_floor": 0.067}}
    closure = replace(answer.closure, rms=rms, by_recalibration=(0.93, (0.92, 0.94)), closed_share_where_fitted=(0.93, (0.92, 0.94)))
    judged = replace(answer.judgement, chosen=Hypothesis(()), likely=(Hypothesis(()),))
    said = sentence(replace(answer, verdict="mistuned", effects=(), judgement=judged, closure=closure), share=False)
    assert ("What it leaves of the friction force is 4.3 times the noise" in said) == told


@pytest.mark.parametrize(("left", "told"), [(0.9, True), (0.08, False)])
def test_a_cause_that_leaves_far_more_than_noise_is_not_just_named(outcome: tuple[Diagnosis, Comparison], left: float, told: bool) -> None:
    """ "Cause named: cross talk, use corrected.ssv", of two channels that were swapped, with 13 times the noise left."""
    answer, comparison = outcome
    (channel,) = answer.closure.rms
    rms = {channel: {"nominal": 1.0, "recalibrated": 0.95, "corrected": left, "noise_floor": 0.067}}
    alone = replace(answer.closure.values_alone, closed_share=0.9)
    judged = replace(answer.judgement, probabilities={Hypothesis((EFFECT,)): 0.99}, likely=(Hypothesis((EFFECT,)),))
    top = headline(replace(answer, judgement=judged, closure=replace(answer.closure, rms=rms, values_alone=alone)), comparison)
    assert top.status == ("likely cause" if told else "cause named")
    assert top.tone == ("attention" if told else "good")
    assert ("What it leaves of the friction force is 13 times the noise" in top.sentence) == told
    assert top.next.startswith("look at what is left before corrected.ssv is used" if told else "use corrected.ssv")


def test_another_form_of_the_law_in_the_set_is_told(outcome: tuple[Diagnosis, Comparison]) -> None:
    """ "Only mis-tuned", effects: none, and a set that switches one on."""
    answer, comparison = outcome
    judged = replace(answer.judgement, chosen=Hypothesis(()), likely=(Hypothesis(()),))
    formed = replace(comparison, recalibrated=comparison.models[Hypothesis((EFFECT,))])
    plain = replace(answer, verdict="mistuned", effects=(), judgement=judged)
    line = f"corrected.ssv switches {EFFECT} on: so little of it is another form of the law, and no effect."
    assert line in headline(plain, formed).reasons
    assert line not in headline(plain, comparison).reasons
    assert line not in headline(answer, comparison).reasons


def test_below_even_odds_a_cause_is_called_unsure(outcome: tuple[Diagnosis, Comparison]) -> None:
    """ "Most likely caused by" what had 49 %, above what was true at 31 %, and then "use corrected.ssv"."""
    answer, comparison = outcome
    on, other = Hypothesis((EFFECT,)), Hypothesis(("sensor_offset",))
    judged = replace(answer.judgement, probabilities={on: 0.49, other: 0.31, Hypothesis(()): 0.15}, likely=(on, other, Hypothesis(())))
    open_ = replace(answer, judgement=judged, advice=Advice("b", {"slip_velocity": 0.01}, (on, other), 0.72))
    said = headline(open_, comparison)
    assert (said.status, said.tone) == ("cause unsure", "attention")
    assert sentence(open_, share=False) == (
        f"The likeliest cause of the gap, and no likelier than not, is {EFFECT} (probability 49 %); "
        "it may be sensor_offset (31 %) or no effect (15 %) instead."
    )
    assert said.next.endswith(f" rms: with a probability of 72 % that tells {EFFECT} from sensor_offset.")
    assert "use corrected.ssv" not in said.next
    assert headline(replace(open_, advice=None), comparison).next.startswith("record more conditions")


def test_an_experiment_is_advised_where_the_words_do(outcome: tuple[Diagnosis, Comparison]) -> None:
    """The words said to put the clock right, or to use the values, and the file beside them advised another condition."""
    answer, comparison = outcome
    on, other, none = Hypothesis((EFFECT,)), Hypothesis(("sensor_offset",)), Hypothesis(())
    advised = replace(answer, advice=Advice("b", {"slip_velocity": 0.01}, (on, other), 0.72))
    sure = replace(answer.judgement, chosen=none, likely=(none,))
    unsure = replace(answer.judgement, probabilities={on: 0.5, other: 0.4, none: 0.1}, likely=(on, other))
    clock = SetUpError("friction_force", "clock", 2e-4, 1e-5, "s", 1e-3, False, {"friction_force": 1.0})
    off = replace(answer.recalibration, notable=(clock,))
    answers = [
        replace(advised, **changed)
        for changed in (
            {},
            {"later": "what follows leaves more"},
            {"judgement": unsure},
            {"judgement": unsure, "verdict": "ambiguous"},
            {"judgement": sure, "effects": (), "verdict": "mistuned"},
            {"judgement": sure, "effects": (), "verdict": "no_gap"},
            {"judgement": sure, "effects": (), "verdict": "no_gap", "recalibration": off},
            {"judgement": replace(unsure, chosen=none), "effects": (), "verdict": "no_gap", "recalibration": off},
            {"judgement": sure, "effects": (), "verdict": "unknown"},
            {"effects": (), "verdict": "cannot_tell"},
        )
    ]
    for each in answers:
        _agrees(each.next_step, TEXT)
        document, words = json.loads(each.json()), headline(each, comparison).next
        assert (
            (document["next_experiment"] is not None) == ("with a probability of 72 % that tells" in words) == (each.next_step in RECORDED)
        )
        if document["next_experiment"] is not None:
            _agrees(
                document["next_experiment"],
                {"condition": TEXT, "values": {"<>": NUMBER}, "separates": [[TEXT]], "expected_probability": NUMBER},
            )
    assert {each.next_step in RECORDED for each in answers} == {True, False}


def test_a_share_that_there_is_none_of_is_no_model_that_fails(outcome: tuple[Diagnosis, Comparison]) -> None:
    answer, comparison = outcome
    for share, why in ((float("nan"), "there is no gap to close"), (0.1, "it does not hold")):
        closure = replace(answer.closure, closed_share=share, interval=(share, share), held_out_conditions=("c1",))
        assert headline(replace(answer, closure=closure), comparison).next.startswith(
            f"do not use the corrected model yet: {why} where no fit has looked."
        )


def test_how_sure_an_effect_is_counts_all_that_it_may_act_with(outcome: tuple[Diagnosis, Comparison]) -> None:
    """ "The cause is named: probability 20 %", above a table in which it acts in 95 of 100, mostly with another."""
    answer, _ = outcome
    on, both, also = Hypothesis((EFFECT,)), Hypothesis((EFFECT, "run_out")), Hypothesis((EFFECT, "sensor_offset"))
    judged = replace(answer.judgement, probabilities={on: 0.20, both: 0.43, also: 0.32, Hypothesis(()): 0.05}, likely=(both, also, on))
    assert sentence(replace(answer, judgement=judged), share=False) == (
        f"The gap is caused by {EFFECT} (probability 95 %); beside it, perhaps, run_out (43 %) or sensor_offset (32 %)."
    )


def test_no_effect_is_one_of_what_data_cannot_tell_apart(outcome: tuple[Diagnosis, Comparison]) -> None:
    """A list of one is no choice."""
    answer, _ = outcome
    judged = replace(answer.judgement, likely=(Hypothesis((EFFECT,)), Hypothesis(())))
    said = sentence(replace(answer, verdict="ambiguous", judgement=judged), share=False)
    assert said == f"One of these, which the data cannot tell apart: {EFFECT}; no effect."


def test_recalibration_that_closes_nothing_is_not_said_to_close_the_gap(outcome: tuple[Diagnosis, Comparison]) -> None:
    answer, comparison = outcome
    for share, said in ((-0.13, "hardly closes the gap"), (0.97, "closes the gap")):
        closure = replace(
            answer.closure, by_recalibration=(share, (share - 0.01, share + 0.01)), closed_share_where_fitted=(share, (share, share))
        )
        judged = replace(answer.judgement, chosen=Hypothesis(()), likely=(Hypothesis(()),))
        top = headline(replace(answer, verdict="mistuned", effects=(), judgement=judged, closure=closure), comparison)
        assert said in top.sentence
        assert top.next.startswith("do not use" if share < 0 else "use the recalibrated values")
        assert (top.tone == "attention") == (share < 0)


def test_the_command(outcome: tuple[Diagnosis, Comparison], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From a folder to the three files; a place, an effect or an FMU that cannot be is refused before any work."""
    import evat.gap
    from evat.commands.main import app
    from evat.gap import report

    asked = list[str]()

    def diagnose(read: Experiment, *_: object, **__: object) -> tuple[Diagnosis, Comparison]:
        asked.append(read.title)
        return outcome

    monkeypatch.setattr(evat.gap, "diagnose_with", diagnose)
    folder = write_experiment(experiment(), tmp_path / "rig")
    arguments = ["diagnose", str(folder), "-o", str(tmp_path / "out")]
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    (theirs / "thesis.txt").write_text("years", encoding="utf-8")
    for more, word in ((["-o", str(theirs)], "no diagnosis"), (["--explain", "warp_drive"], "warp_drive"), (["--fmu", "no.fmu"], "no.fmu")):
        refused = CliRunner().invoke(app, [*arguments, *more])
        assert refused.exit_code != 0
        assert word in str(refused.exception)
        assert asked == []
    result = CliRunner().invoke(app, [*arguments, "--no-fmu", "--explain", "sensor_gain"])
    assert result.exit_code == 0, result.output
    assert asked == ["rig"]
    assert "sensor_gain: " in result.output
    assert f"caused by {EFFECT}" in " ".join(result.output.split())
    assert json.loads((tmp_path / "out" / "diagnosis.json").read_text(encoding="utf-8"))["made_by"]["seconds"] >= 0
    with monkeypatch.context() as patched:  # what was written is told, also where nothing can be explained
        patched.setattr(report, "explain", lambda *_: 1 / 0)
        assert "diagnosis.json" in CliRunner().invoke(app, [*arguments, "--no-fmu", "--explain", "sensor_gain"]).output
    verdict = CliRunner().invoke(app, [*arguments, "--no-fmu", "--explain", "unknown"])
    assert verdict.exit_code == 0, verdict.output
    assert "unknown: this is not the verdict, which is effect." in verdict.output
    for name in ("data_suffice", "structural_gap", "known_to_library", "known_is_likelier"):
        assert f". {name}: " in verdict.output
    assert "called with --no-fmu" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
