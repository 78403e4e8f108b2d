"""Do simulated tests of a known contact obey its law, carry the noise that was asked for, and keep the truth to themselves?"""

from __future__ import annotations

import subprocess
from collections.abc import Mapping
from pathlib import Path

import command_line
import numpy as np
import pytest
from evat import parameter_sets
from evat.experiment import Experiment
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.model import EvatError, ParameterError
from evat.models.contact import ContactModel
from evat.models.simulate import simulate
from evat.motions import ACCELERATION, KINDS, PLATEAU
from evat.native import kernel
from evat.studies.orthogonal import HEATED, orthogonal, uncertain

FAMILIES = ("lugre-1995", "regularised/copper", "regularised/al-6061", "regularised/al-7075-t6", "regularised/inconel-718")


def values_of(name: str) -> tuple[dict[str, float | str | bool], tuple[str, ...]]:
    parameter_set = parameter_sets.load(name)
    return kernel.by_choice(parameter_set.values), tuple(parameter_set.effects)


def experiment_of(name: str, **options: object) -> Experiment:
    values, effects = values_of(name)
    return orthogonal(values, effects, **{"noise": 0.0, "nominal_off": 0.0, "repeats": 1, **options})  # type: ignore[arg-type]


def steady_force(values: Mapping[str, float | str], speed: float, theta: float | None, softens: bool) -> float:
    """Steady sliding by the paper's eqs. 6 and 8: dz/dt = 0, z = g/P."""
    P, F_C, F_S, v_s, sigma2 = (float(values[name]) for name in ("sigma0", "F_C", "F_S", "v_s", "sigma2"))
    g = F_C + (F_S - F_C) * np.exp(-((speed / v_s) ** 2))
    k_Q, Q, ref = (float(values.get(name, 0)) for name in ("thermal_softening.k_Q", "thermal_softening.Q", "theta_ref"))
    s0 = P - k_Q * ((speed if theta is None else theta) / ref) ** Q if softens else P
    return float(s0 / P * g + sigma2 * speed)


@pytest.mark.parametrize("name", FAMILIES)
def test_at_a_test_speed_friction_is_the_static_curve(name: str) -> None:
    """After a second at constant speed the bristles stand still. Tolerance: that of the integration, 1e-6, with room for its sum."""
    values, effects = values_of(name)
    simulated = experiment_of(name)
    assert len(simulated.conditions) == 5
    for trial in simulated.trials:
        speed = trial.values["cutting_speed"]
        assert trial.inputs["slip_velocity"][-1] == speed
        wanted = steady_force(values, speed, None, "thermal_softening" in effects)
        assert trial.outputs["friction_force"][-1] == pytest.approx(wanted, rel=1e-5)
        assert wanted > 0


def test_a_ramp_is_that_of_the_papers_tests() -> None:
    """From rest at constant acceleration to the speed, then constant."""
    for trial in experiment_of("regularised/copper", speeds=[0.1, 0.7], rate=500).trials:
        speed, velocity = trial.values["cutting_speed"], trial.inputs["slip_velocity"]
        assert trial.times[-1] == pytest.approx(ACCELERATION + PLATEAU, abs=1e-9)
        assert velocity == pytest.approx(np.minimum(trial.times / ACCELERATION, 1) * speed, abs=1e-12)


def test_small_strokes_meet_a_spring_and_large_ones_slip() -> None:
    """LuGre 1995. Strokes of 0.3 of the length over which bristles bend meet their stiffness, less what yields: at most the 0.3 itself.
    Strokes of 3 of it slip: the force stops at F_S, and so its slope falls towards 1/3."""
    values, _ = values_of("lugre-1995")
    simulated = experiment_of("lugre-1995", motion="presliding")
    sigma0, F_S = float(values["sigma0"]), float(values["F_S"])
    small, large = simulated.trials[0], simulated.trials[-1]
    for trial, share in ((small, 0.3), (large, 3.0)):
        velocity = trial.inputs["slip_velocity"]
        x = np.concatenate([[0], np.cumsum((velocity[1:] + velocity[:-1]) / 2 * np.diff(trial.times))])
        assert np.ptp(x) / 2 == pytest.approx(share * F_S / sigma0, rel=1e-3)  # trapezoids of a sine, 200 a stroke
        stiffness = np.polyfit(x, trial.outputs["friction_force"], 1)[0] / sigma0
        assert (0.7 if share < 1 else 0.1) < stiffness < (1.0 if share < 1 else 0.5)
        work = np.trapezoid(trial.outputs["friction_force"] * velocity, trial.times)
        assert work > 0
    assert 0.8 * F_S < np.abs(large.outputs["friction_force"]).max() < F_S  # above F_C = 2/3 F_S; lag keeps it below F_S


@pytest.mark.parametrize("proxy", ["contact_temperature", "proxy_speed"])
def test_heat_softens_as_the_paper_says(proxy: str) -> None:
    """Al 6061, the material whose stiffness falls most: at the peak of each swing friction is eq. 6 at that level. Tolerance: a peak passes
    within a sample, and the bristles lag by F/sigma0 of way behind it."""
    values, _ = values_of("regularised/al-6061")
    simulated = experiment_of("regularised/al-6061", motion="temperature", proxy=proxy)
    at_peak = []
    for trial in simulated.trials:
        level = trial.inputs[proxy][-1]
        ambient, reference, alpha, ref = (
            float(values.get(name, kernel.variable(name).start))
            for name in ("ambient_temperature", "reference_temperature", "alpha_T", "theta_ref")
        )
        theta = level if proxy == "proxy_speed" else ref * ((level - ambient) / (reference - ambient)) ** (1 / alpha)
        peak = int(np.argmax(trial.inputs["slip_velocity"]))
        speed = trial.inputs["slip_velocity"][peak]
        assert trial.outputs["friction_force"][peak] == pytest.approx(steady_force(values, speed, theta, True), rel=1e-3)
        at_peak.append(trial.outputs["friction_force"][peak])
        assert trial.inputs[proxy][0] == (0 if proxy == "proxy_speed" else ambient)  # first cold, then a step
    assert at_peak[0] > at_peak[1] > at_peak[2] + 1


@pytest.mark.parametrize("motion", KINDS)
def test_every_motion_moves_every_set_and_none_breaks_eq_7(motion: str) -> None:
    for name in FAMILIES:
        simulated = experiment_of(name, motion=motion)
        assert all(np.all(np.isfinite(trial.outputs["friction_force"])) for trial in simulated.trials)
        assert len(simulated.conditions) == len(simulated.trials) >= 3
        _, effects = values_of(name)
        if "thermal_softening" not in effects:
            continue
        for trial in simulated.trials:
            clamped = simulate(
                {**simulated.nominal.values, **trial.values}, effects, times=trial.times, inputs=trial.inputs, outputs=("clamped_count",)
            )
            assert clamped["clamped_count"][-1] == 0, (name, trial.condition)


def change(name: str, motion: str, **off: float) -> float:
    """How far friction moves, root mean square over that of friction, when parameters are multiplied."""
    simulated, (_, effects) = experiment_of(name, motion=motion), values_of(name)
    distance = whole = 0.0
    for trial in simulated.trials:
        values = {**simulated.nominal.values, **trial.values, "relative_tolerance": 1e-6}
        values |= {key: float(values[key]) * factor for key, factor in off.items()}
        force = simulate(values, effects, times=trial.times, inputs=trial.inputs, outputs=("friction_force",))["friction_force"]
        distance += float(np.sum((force - trial.outputs["friction_force"]) ** 2))
        whole += float(np.sum(trial.outputs["friction_force"] ** 2))
    return float(np.sqrt(distance / whole))


def test_what_a_ramp_hides_other_motions_show() -> None:
    """Each parameter 10 % off, what that does in shares of the force. Plain LuGre sliding one way: sigma0 and sigma1 cancel but for the
    first instant; strokes and reversals show them."""
    for parameter in ("sigma0", "sigma1"):
        assert change("lugre-1995", "ramp", **{parameter: 1.1}) < 3e-3
    assert change("lugre-1995", "presliding", sigma0=1.1) > 0.03
    assert change("lugre-1995", "presliding", sigma1=1.1) > 5e-3
    assert change("lugre-1995", "reversal", sigma1=1.1) > 5e-3
    # copper's damping acts only where it is hot and nearly at rest
    assert change("regularised/copper", "ramp", sigma1=1.1) < 1e-5
    assert change("regularised/copper", "heated_presliding", sigma1=1.1) > 5e-3
    # with the damping limited, no motion shows that of Inconel
    assert max(change("regularised/inconel-718", motion, sigma1=1.1) for motion in KINDS) < 1e-4


@pytest.mark.parametrize("noise", [0.01, 0.2])
def test_noise_is_white_and_as_strong_as_asked_for(noise: float) -> None:
    """N = 45 000: the standard deviation is known to 1/sqrt(2 N) = 0.3 %, a correlation to 1/sqrt(N) = 0.5 %; five of each are allowed."""
    clean, noisy = (experiment_of("lugre-1995", noise=level, repeats=3, seed=5) for level in (0.0, noise))
    pairs = [(a.outputs["friction_force"], b.outputs["friction_force"]) for a, b in zip(clean.trials, noisy.trials, strict=True)]
    rms = np.sqrt(np.mean(np.concatenate([truth for truth, _ in pairs]) ** 2))
    error = np.concatenate([measured - truth for truth, measured in pairs])
    assert np.std(error) == pytest.approx(noise * rms, rel=5 / np.sqrt(2 * error.size))
    assert abs(np.mean(error)) < 5 * noise * rms / np.sqrt(error.size)
    assert abs(np.corrcoef(error[1:], error[:-1])[0, 1]) < 5 / np.sqrt(error.size)
    repeats = [measured - truth for truth, measured in pairs[:2]]
    assert abs(np.corrcoef(*repeats)[0, 1]) < 5 / np.sqrt(repeats[0].size)


def test_the_seed_decides_and_nothing_else(tmp_path: Path) -> None:
    first, same, other, known = (
        experiment_of("regularised/copper", noise=0.01, seed=seed, nominal_off=off)
        for seed, off in ((1, 0.3), (1, 0.3), (2, 0.3), (1, 0.0))
    )
    force = [each.trials[0].outputs["friction_force"] for each in (first, same, other, known)]
    assert np.array_equal(force[0], force[1])
    assert not np.array_equal(force[0], force[2])
    assert np.array_equal(force[0], force[3])  # how far off the nominal model is does not touch the noise
    assert first.nominal.values == same.nominal.values != other.nominal.values
    written = [write_experiment(each, tmp_path / str(place)) for place, each in enumerate((first, same))]
    assert read_experiment(written[0], ContactModel()).data_hash == read_experiment(written[1], ContactModel()).data_hash


def test_the_nominal_model_is_off_in_what_is_to_be_found_and_in_nothing_else() -> None:
    values, effects = values_of("published/copper")
    shares = {name: [] for name in uncertain()}
    for seed in range(60):
        nominal = orthogonal(values, effects, speeds=[0.1], repeats=1, rate=10, seed=seed, nominal_off=0.3).nominal
        assert {name: value for name, value in nominal.values.items() if name in values and name not in shares} == {
            name: value for name, value in values.items() if name not in shares
        }
        assert nominal.effects == effects
        assert set(nominal.relative_sd) == set(shares)
        for name, off in shares.items():
            off.append(float(nominal.values[name]) / float(values[name]) - 1)
    for name, off in shares.items():
        assert 0.2 < max(np.abs(off)) <= 0.3 + 1e-12, name
        assert np.std(off) == pytest.approx(nominal.relative_sd[name], rel=0.35)  # 60 draws: 9 %, four of these


@pytest.mark.parametrize("motion", KINDS)
def test_the_folder_reads_back_and_does_not_tell(tmp_path: Path, motion: str) -> None:
    values, effects = values_of("published/copper")
    made = orthogonal(values, effects, motion=motion, repeats=2, seed=3)
    recorded = read_experiment(write_experiment(made, tmp_path / "rig"), ContactModel())
    for ours, theirs in zip(made.trials, recorded.trials, strict=True):
        assert ours.times.tobytes() == theirs.times.tobytes()
        for name, column in {**ours.inputs, **ours.outputs}.items():
            assert column.tobytes() == {**theirs.inputs, **theirs.outputs}[name].tobytes()
    assert recorded.nominal == made.nominal
    assert ("proxy_source" in recorded.nominal.values) == (motion in HEATED)
    document = (tmp_path / "rig" / "experiment.toml").read_text()
    assert "copper" not in document
    for name in uncertain():
        assert repr(values[name]) not in document


@pytest.mark.parametrize(
    ("options", "what"),
    [
        ({"motion": "jump"}, "no motion 'jump'; there are ramp, steps"),
        ({"repeats": 0}, "repeats = 0"),
        ({"noise": -0.1}, "noise = -0.1"),
        ({"noise": float("nan")}, "noise = nan"),
        ({"rate": 0}, "rate = 0 Hz"),
        ({"nominal_off": 1.0}, "nominal_off = 1"),
        ({"speeds": []}, "at least one is needed"),
        ({"speeds": [0.1, -0.1]}, "each above 0"),
        ({"proxy": "cutting_speed"}, "proxy 'cutting_speed'"),
        ({"outputs": ("slip_velocity",)}, "outputs slip_velocity: name outputs"),
        ({"outputs": ()}, "outputs none"),
    ],
)
def test_tests_that_make_no_sense_are_refused(options: dict[str, object], what: str) -> None:
    with pytest.raises(ParameterError, match=what):
        experiment_of("lugre-1995", **options)
    with pytest.raises(EvatError, match="F_X"):
        orthogonal({"F_X": 1.0})


def evat(*arguments: str, at: Path) -> subprocess.CompletedProcess[str]:
    return command_line.evat("experiment", *arguments, folder=at, columns=120)


def test_the_truth_is_kept_apart_and_explains_the_data(tmp_path: Path) -> None:
    """Run at the truth, the contact leaves the noise and no more; at the nominal model it leaves much more."""
    arguments = ("-s", "regularised/copper", "--noise", "1 %", "--seed", "1", "--repeats", "2", "--out", "rig", "--truth", "truth.ssv")
    done = evat("orthogonal", *arguments, "--motion", "reversal", "--suffix", ".parquet", at=tmp_path)
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rig", "truth.ssv"]
    assert sorted(path.name for path in (tmp_path / "rig").iterdir()) == ["experiment.png", "experiment.toml", "trials"]
    recorded, truth = read_experiment(tmp_path / "rig", ContactModel()), parameter_sets.load(tmp_path / "truth.ssv")
    left = {}
    for name, values, effects in (("truth", truth.values, truth.effects), ("nominal", recorded.nominal.values, recorded.nominal.effects)):
        error = whole = 0.0
        for trial in recorded.trials:
            run = {**values, **trial.values, "relative_tolerance": 1e-6}
            force = simulate(run, effects, times=trial.times, inputs=trial.inputs, outputs=("friction_force",))["friction_force"]
            error += float(np.sum((force - trial.outputs["friction_force"]) ** 2))
            whole += float(np.sum(force**2))
        left[name] = np.sqrt(error / whole)
    assert left["truth"] == pytest.approx(0.01, rel=0.02)  # 60 000 samples: 0.3 % each way
    assert left["nominal"] > 0.05


def test_check_tells_what_is_there(tmp_path: Path) -> None:
    made = experiment_of("lugre-1995", repeats=2, noise=0.01, speeds=[0.1, 0.5])
    write_experiment(made, tmp_path / "rig")
    done = evat("check", "rig", at=tmp_path)
    assert done.returncode == 0, done.stderr
    told = " ".join(done.stdout.split())
    assert "4 trials of 12004 rows in all; 2 conditions" in told
    for fact in (
        "trials/02-01.csv",
        "speed 2",
        "3001",
        "1000",
        "friction_force",
        "output",
        "F_C = 1 N",
        read_experiment(tmp_path / "rig", ContactModel()).data_hash,
    ):
        assert fact in told, fact
    rms = np.sqrt(np.mean(made.trials[0].outputs["friction_force"] ** 2))
    assert f"{rms:.4g} N" in told


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        (("check", "."), "there is no such file; an experiment is a folder"),
        (("orthogonal", "--out", "rig", "-s", "lugre-1995", "--truth", "rig/truth.ssv"), "an .ssv file outside rig is needed"),
        (("orthogonal", "--out", "rig", "-s", "lugre-1995", "--noise", "1 N"), "noise = '1 N'"),
        (("orthogonal", "--out", "rig", "-s", "lugre-1996"), "no parameter set 'lugre-1996'"),
        (("orthogonal", "--out", "full", "-s", "lugre-1995"), "measurements are not overwritten"),
    ],
)
def test_the_command_says_what_is_wrong(tmp_path: Path, arguments: tuple[str, ...], what: str) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("")
    done = evat(*arguments, at=tmp_path)
    assert done.returncode == 2
    assert what in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["full"]
