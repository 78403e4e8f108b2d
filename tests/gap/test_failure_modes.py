"""Does the diagnosis answer as it must where it is easy to be wrong? The failure modes, each with its answer, on the component itself."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
import pytest
import toy
from evat.constants import CONSTANTS
from evat.experiment import Experiment
from evat.gap import Diagnosis, diagnose, diagnose_with
from evat.gap.report.explanation import smallest_amplitudes
from evat.gap.search.audit import audit, idle_effects, too_slow, varying
from evat.inference.prediction import Prediction
from evat.model import FloatArray, Variable
from rig import MODEL, SAMPLES, STEP, STILL, VALUES, measured

LEAN = {"direction_asymmetry.a": 0.06}
AGAIN = pytest.mark.campaign  # a diagnosis takes ten seconds: more of one kind are made where they are asked for


def names(answer: Diagnosis) -> list[str]:
    return [effect.name for effect in answer.effects]


@AGAIN  # with a hundredth of an effect: test_of_an_effect_that_is_too_small_is_said_how_large_it_would_have_to_be
def test_the_same_thing_twice_is_no_gap() -> None:
    answer = diagnose(measured(), MODEL)
    assert (answer.verdict, names(answer)) == ("no_gap", [])


def test_a_pair_that_cannot_be_told_apart_is_named_as_such() -> None:
    """In sliding, a share a of the Coulomb force and a zero of a F_C are one and the same."""
    coulomb: dict[str, float | str] = {"friction_law": "coulomb", "sigma2": 0.0}
    answer = diagnose(measured(["sensor_offset"], {**coulomb, "sensor_offset.friction_force": 0.8}, nominal=coulomb), STILL)
    assert answer.verdict in ("ambiguous", "effect")
    candidates = {name for on in answer.judgement.likely for name in on}
    assert {"sensor_offset", "direction_asymmetry"} <= candidates
    assert answer.next_experiment is not None


def test_the_larger_of_two_effects_is_found_at_least() -> None:
    answer = diagnose(measured(["direction_asymmetry", "sensor_drift"], {**LEAN, "sensor_drift.friction_force": 0.1}), STILL)
    assert "direction_asymmetry" in names(answer)


@pytest.mark.parametrize(
    ("extra", "swings"),
    [
        (lambda times: 1.8 * np.sin(2 * np.pi * 87.3 * times) * (np.mod(5 * times, 1.0) < 0.3), True),  # chatter in every stroke
        pytest.param(lambda times: 2.0 * (np.mod(11.3 * times, 1.0) - 0.5), False, marks=AGAIN),  # the sawtooth of a built-up edge
        pytest.param(lambda times: 4.0 * (np.mod(17.7 * times, 1.0) < 0.06), False, marks=AGAIN),  # adhesion
    ],
    ids=["chatter", "sawtooth", "spikes"],
)
def test_what_is_outside_the_library_is_unknown(extra: object, swings: bool) -> None:
    answer = diagnose(measured(extra=extra), MODEL if swings else STILL)  # type: ignore[arg-type]
    assert (answer.verdict, names(answer)) == ("unknown", [])
    assert answer.judgement.unknown > 0.5


def test_a_line_that_is_always_there_is_a_disturbance_of_the_signal() -> None:
    answer = diagnose(measured(extra=lambda times: 1.2 * np.sin(2 * np.pi * 87.3 * times)), MODEL)
    assert (answer.verdict, names(answer)) == ("effect", ["line_disturbance"])
    assert answer.effects[0].parameters["frequency"][0] == pytest.approx(87.3, rel=1e-3)


def test_a_nominal_model_that_is_far_off_is_recalibrated() -> None:
    answer = diagnose(measured(truth={"F_C": 11.7, "F_S": 14.3}), STILL)
    assert answer.verdict == "mistuned"
    assert answer.recalibration.parameters["F_C"][1] == pytest.approx(11.7, rel=0.03)
    assert answer.recalibration.explains_share > 0.95


def _outliers(draw: np.random.Generator, size: int) -> FloatArray:
    row: FloatArray = draw.normal(size=size) + (draw.random(size) < 0.02) * draw.normal(size=size) * 15
    return row


def _t3(draw: np.random.Generator, size: int) -> FloatArray:
    row: FloatArray = draw.standard_t(3, size=size)
    return row


@pytest.mark.parametrize("noise", [pytest.param(_t3, marks=AGAIN), _outliers], ids=["t3", "outliers"])
def test_heavy_tails_do_not_change_the_answer(noise: object) -> None:
    answer = diagnose(measured(["direction_asymmetry"], LEAN, noise=noise), STILL)  # type: ignore[arg-type]
    assert names(answer) == ["direction_asymmetry"]
    assert answer.effects[0].parameters["a"][0] == pytest.approx(0.06, abs=0.015)
    # Friction alone is recorded: what acts on cutting forces cannot be told.
    assert any(line.startswith(("edge_force:", "cross_talk:")) for line in answer.cannot_tell)


@AGAIN  # that they name nothing beside what is there is seen above in each run
@pytest.mark.parametrize("noise", [_t3, _outliers], ids=["t3", "outliers"])
def test_heavy_tails_are_no_gap(noise: object) -> None:
    assert diagnose(measured(noise=noise), STILL).verdict == "no_gap"  # type: ignore[arg-type]


def test_a_clock_that_is_late_is_a_delay() -> None:
    assert names(diagnose(measured(late=6e-3), STILL)) == ["sensor_delay"]


@pytest.mark.parametrize("late", [pytest.param(2e-3, marks=AGAIN), -2e-3])
def test_a_clock_that_is_late_or_early_by_two_samples_is_the_set_up(late: float) -> None:
    answer = diagnose(measured(late=late), STILL)
    assert names(answer) == []
    assert answer.recalibration.setup["friction_force"]["clock"][0] == pytest.approx(late, abs=5e-4)


def test_one_recording_says_nothing_of_repeatability() -> None:
    experiment = measured(["direction_asymmetry"], {"direction_asymmetry.a": 0.15}, repeats=1)
    answer = diagnose(experiment, STILL)
    assert any("repeatability" in note for note in answer.cannot_tell)
    assert "direction_asymmetry" in {name for on in answer.judgement.likely for name in on}


def test_what_needs_a_proxy_that_does_not_vary_is_not_identifiable() -> None:
    still = {"proxy_speed": lambda times, place: np.full(times.size, 0.2)}
    proxy: dict[str, float | str] = {"proxy_source": "proxy_speed", "theta_ref": 0.1}
    softer = {**proxy, "thermal_softening.k_Q": 2e4, "thermal_softening.Q": 1.0}
    answer = diagnose(measured(["thermal_softening"], softer, nominal=proxy, inputs=still), STILL)
    assert "thermal_softening" not in names(answer)
    assert any(note.startswith("thermal_softening: not identifiable, proxy_speed") for note in answer.cannot_tell)


@pytest.mark.parametrize(("rises", "idle"), [(5.0, False), (0.05, True)])
def test_a_temperature_varies_beside_what_the_model_counts_it_from(rises: float, idle: bool) -> None:
    """It had to vary by 2 % of 293 K: a viscosity that changed friction by a sixth over 5 K was `mistuned`, as nothing varied."""
    nominal = {**VALUES, "proxy_source": "contact_temperature", "ambient_temperature": 293.15, "reference_temperature": 298.15}
    warm = {"contact_temperature": lambda times, place: 293.45 + rises * place / 3 + 0 * times}
    prediction = Prediction(STILL, measured(nominal=nominal, inputs=warm))
    told = idle_effects(prediction, [effect for effect in STILL.effects if effect.name == "thermal_viscosity"])
    assert told == ({"thermal_viscosity": ("contact_temperature",)} if idle else {})
    assert "slip_velocity" in varying(prediction)


def test_softening_is_named_where_the_proxy_varies_enough() -> None:
    """The paper's own step, from LuGre to its new model."""
    moving = {"proxy_speed": lambda times, place: 0.2 + 0.15 * np.sin(2 * np.pi * 1.7 * times + place)}
    proxy: dict[str, float | str] = {"proxy_source": "proxy_speed", "theta_ref": 0.1}
    softer = {**proxy, "thermal_softening.k_Q": 2e4, "thermal_softening.Q": 1.0}
    assert names(diagnose(measured(["thermal_softening"], softer, nominal=proxy, inputs=moving), STILL)) == ["thermal_softening"]


@pytest.mark.parametrize("place", [0, -1])
def test_a_record_that_was_sampled_too_slowly_is_seen_wherever_it_stands(place: int) -> None:
    slow = measured()
    values: dict[str, float | str] = {**VALUES, "kinematics": "internal", "vibration_frequency": 0.02 / STEP}
    trials = [replace(trial, inputs={}) for trial in slow.trials]
    trials[place] = replace(trials[place], times=trials[place].times * 10)
    experiment = replace(slow, nominal=replace(slow.nominal, values=values), trials=tuple(trials))
    assert trials[place].file in too_slow(Prediction(STILL, experiment))
    assert not too_slow(Prediction(STILL, replace(experiment, trials=tuple(t for t in trials if t is not trials[place]))))


def test_a_sensor_below_the_vibration_claims_no_phase() -> None:
    slow = measured()
    times = np.arange(SAMPLES) * STEP
    values: dict[str, float | str] = {**VALUES, "kinematics": "internal", "vibration_frequency": 2e4}
    trials = tuple(replace(trial, times=times, inputs={}) for trial in slow.trials)
    answer = diagnose(replace(slow, nominal=replace(slow.nominal, values=values), trials=trials), STILL)
    assert answer.verdict == "cannot_tell"
    assert any("phases cannot be seen" in note for note in answer.cannot_tell)


def _changed(experiment: Experiment, factor: float) -> Experiment:
    trials = tuple(replace(t, outputs={name: factor * row for name, row in t.outputs.items()}) for t in experiment.trials)
    return replace(experiment, trials=trials)


@pytest.mark.parametrize(("factor", "said"), [(1000.0, "check its unit"), (-1.0, "check its sign"), (0.0, "sensor connected")])
def test_wrong_units_signs_and_dead_sensors_are_told(factor: float, said: str) -> None:
    answer = diagnose(_changed(measured(), factor), STILL)
    assert answer.verdict == "cannot_tell"
    assert any(said in note for note in answer.cannot_tell)


def test_a_solver_that_is_too_coarse_is_told() -> None:
    """Of a toy; the component's own error control leaves no such error at any tolerance that it allows."""

    class Coarse(toy.Toy):
        variables = (*toy.Toy.variables, Variable("relative_tolerance", "1", 1e-4, 1e-12, 1.0, "tolerance", "toy"))

        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            return {"F": super().formula(times, values, on)["F"] + values["relative_tolerance"] * np.sin(40 * times)}

    experiment = toy.measured(noise=0.1)
    for tolerance, verdict in ((1.0, "cannot_tell"), (1e-3, "no_gap")):
        nominal = replace(experiment.nominal, values={"k": 10.0, "relative_tolerance": tolerance})
        answer = diagnose(replace(experiment, nominal=nominal), Coarse())
        assert answer.verdict == verdict
        assert any("solver's own error" in note for note in answer.cannot_tell) == (verdict == "cannot_tell")


@pytest.mark.parametrize("newton", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("error", "refused"), [(0.5, False), (2.0, True)])
def test_what_error_a_solver_may_have_is_a_share_of_the_force(newton: float, error: float, refused: bool) -> None:
    """In any unit, where there is next to no noise. error : of what may be seen of it."""
    made = toy.measured(noise=1e-4)
    made = replace(_changed(made, newton), nominal=replace(made.nominal, values={"k": 10.0 * newton}))
    prediction = Prediction(toy.Toy(), made)
    predicted = prediction.one()
    wrong = error * CONSTANTS.visible_solver_error * float(np.sqrt(np.mean(predicted**2)))
    said = audit(prediction, predicted, {"F": 1e-4 * newton}, np.full_like(predicted, wrong)).refused
    assert any("solver's own error" in reason for reason in said) == refused


@pytest.mark.parametrize("on", [(), ("bend",)])
def test_a_channel_of_noise_changes_nothing(on: tuple[str, ...]) -> None:
    """One more output, of which the model says that it is zero, and which is nothing but noise."""

    class Wider(toy.Toy):
        variables = (*toy.Toy.variables, Variable("G", "N", 0.0, -1e9, 1e9, "another force", "toy", causality="output"))

        def formula(self, times: FloatArray, values: Mapping[str, FloatArray], on: Collection[str]) -> Mapping[str, FloatArray]:
            force = super().formula(times, values, on)["F"]
            return {"F": force, "G": np.zeros_like(force)}

    draw = np.random.default_rng(8)
    plain = toy.measured(on, {"bend.c": 0.2} if on else {})
    trials = [replace(trial, outputs={**trial.outputs, "G": 0.3 * draw.normal(size=trial.times.size)}) for trial in plain.trials]
    without, answer = diagnose(plain, toy.Toy()), diagnose(replace(plain, trials=tuple(trials)), Wider())
    assert (answer.verdict, names(answer)) == (without.verdict, names(without))
    for candidate, probability in without.judgement.probabilities.items():
        assert answer.judgement.probabilities[candidate] == pytest.approx(probability, abs=0.05)
    if on:
        assert answer.where.channels["F"] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("start", [pytest.param(0, marks=AGAIN), 1])
def test_sides_that_are_the_same_have_no_gap(start: int) -> None:
    """Repeats of one condition against each other: halves of the record, whose difference is noise alone."""
    experiment = measured(["direction_asymmetry"], LEAN, repeats=4)
    half, truth = replace(experiment, trials=experiment.trials[start::2]), {**VALUES, **LEAN}
    known = replace(half, nominal=replace(half.nominal, values=truth, effects=("direction_asymmetry",)))
    assert diagnose(known, STILL).verdict == "no_gap"


def test_what_drifts_is_no_heat() -> None:
    """A force that grows with time, beside a proxy that varies: wear or a drifting sensor, no thermal effect."""
    heat = {"proxy_speed": lambda times, place: 0.2 + 0.1 * np.sin(2 * np.pi * times / 0.9 + place)}
    answer = diagnose(measured(["sensor_drift"], {"sensor_drift.friction_force": 1.5}, inputs=heat), STILL)
    assert "sensor_drift" in names(answer)
    assert not any(name.startswith("thermal") for on in answer.judgement.likely for name in on)


def test_of_an_effect_that_is_too_small_is_said_how_large_it_would_have_to_be() -> None:
    """A hundredth of what is named elsewhere here: nothing, among all effects, and the smallest that would show lies between."""
    tiny = {name: value / 100 for name, value in LEAN.items()}
    answer, comparison = diagnose_with(measured(["direction_asymmetry"], tiny), MODEL)
    assert (answer.verdict, names(answer)) == ("no_gap", [])
    effect = next(each for each in MODEL.effects if each.name == "direction_asymmetry")
    smallest = smallest_amplitudes(comparison, comparison.recalibrated, effect)["direction_asymmetry.a"]
    assert tiny["direction_asymmetry.a"] < smallest < LEAN["direction_asymmetry.a"]
