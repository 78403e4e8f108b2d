"""Does a record that was compressed tell what the whole does? Estimates, their standard errors, what changes slowly, and what was done."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import long_record
import numpy as np
import pytest
from evat.commands.main import app
from evat.experiment import Experiment, ExperimentError, Nominal, Signal, Trial, compression
from evat.experiment.columns import trial_columns
from evat.experiment.compression import compress_experiment, overview, read_or_compress
from evat.experiment.compression.overview import Overview
from evat.experiment.compression.pieces import Piece
from evat.experiment.compression.stretches import Stretch, stretches
from evat.experiment.derived import derived, derived_batches
from evat.experiment.document import CLOCK, read_document
from evat.experiment.read import read_experiment
from evat.experiment.write import write_experiment
from evat.identification import Settings, identify
from evat.model import FloatArray, Run
from evat.models.contact import ContactModel
from scipy.signal import lfilter
from typer.testing import CliRunner

MODEL = ContactModel(1)
LONG_RECORD = Path(long_record.__file__)
TRUTH: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 8.0, "F_S": 10.0, "sigma0": 2e4, "sigma1": 60.0, "sigma2": 20.0, "v_s": 0.02,
}  # fmt: skip
WEAR = {"friction_wear.delta": 0.3, "friction_wear.s_0": 1.0}
RATE, CYCLE, ROWS = 250.0, 0.5, 9000  # Hz, s
NOISE, MEMORY = 0.1, 0.9
FREE = ["F_C", "sigma2", "friction_wear.delta"]
BOUNDS = {"friction_wear.delta": (-0.5, 2.0)}
ON = ("friction_wear",)


def program() -> tuple[FloatArray, FloatArray]:
    """36 s: setting out, 40 cycles, held, 20 cycles of another motion, at rest."""
    phase = 2 * np.pi * np.arange(int(CYCLE * RATE)) / (CYCLE * RATE)
    slow, fast = 0.05 * np.sin(phase) + 0.02 * np.sin(3 * phase), 0.15 * np.sin(phase)
    pieces = [np.linspace(0.0, 0.04, 250), np.tile(slow, 40), np.full(750, 0.04), np.tile(fast, 20), np.zeros(500)]
    motion = np.concatenate(pieces)
    return np.arange(motion.size) / RATE, motion


def rig(seed: int = 1) -> Experiment:
    """With wear, and noise that goes on from sample to sample."""
    times, motion = program()
    run = Run(times, {"slip_velocity": motion}, ("friction_force",))
    force = MODEL.simulate(run, ON, {**TRUTH, **WEAR})["friction_force"]
    noise = lfilter([np.sqrt(1 - MEMORY**2)], [1.0, -MEMORY], np.random.default_rng(seed).standard_normal(times.size))
    nominal = {**TRUTH, "F_C": 7.0, "sigma2": 25.0, "friction_wear.s_0": 1.0}
    trial = Trial("long.parquet", "c1", {}, times, {"slip_velocity": motion}, {"friction_force": force + NOISE * noise})
    signals = {
        CLOCK: Signal(CLOCK, "t [s]", "s", None),
        "slip_velocity": Signal("slip_velocity", "v [mm/s]", "mm/s", "input"),
        "friction_force": Signal("friction_force", "F [N]", "N", "output"),
    }
    return Experiment(Path(), "A long recording", "", Nominal(nominal, (), {}, initial_bristle="relaxed"), signals, (trial,), None, "")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_experiment(rig(), tmp_path_factory.mktemp("long") / "rig", suffix=".parquet")


def test_parameters_and_their_errors_are_those_of_the_whole_record(recorded: Path) -> None:
    """Estimates agree within what both leave open, and with the truth; what wears in over the record is seen as surely."""
    compressed = compress_experiment(recorded, MODEL, samples=1000).experiment
    assert compressed.samples < 0.25 * ROWS
    settings = Settings(on=ON, bounds=BOUNDS, search="none", profiles=False)
    whole, short = (identify(each, MODEL, FREE, settings) for each in (read_experiment(recorded, MODEL), compressed))
    for name in FREE:
        of_whole, of_short, truth = whole[name], short[name], {**TRUTH, **WEAR}[name]
        assert abs(of_short.value - float(truth)) < 3.5 * of_short.sd, name
        assert abs(of_short.value - of_whole.value) < 3 * np.hypot(of_short.sd, of_whole.sd), name
        assert 0.5 * of_whole.sd < of_short.sd < 3 * of_whole.sd, name
    assert short["friction_wear.delta"].value > 10 * short["friction_wear.delta"].sd


def test_the_noise_of_an_average_is_that_of_its_halves() -> None:
    """Noise that goes on over three samples, and drift: over 400 records the standard deviation of an average cycle is what its halves say
    it is. By white noise it would be said 2.4 times too small."""
    draw, points, cycles = np.random.default_rng(5), 20, 80
    stretch = Stretch("repeating", 0, cycles * points, np.array([0.0, cycles * points]), np.array([0.0, cycles]))
    means, halves = [], []
    for row in lfilter([1.0], [1.0, -0.7], draw.standard_normal((400, 50 + cycles * points)))[:, 50:]:
        piece = Piece(stretch, 0, cycles * points, points, 1, 2)
        for first in range(0, row.size, 300):  # whatever the batches
            piece.add(first, [row[first : first + 300] + 0.01 * np.arange(first, min(first + 300, row.size))])
        _, values = piece.averages()
        means.append(values[:, 0].mean())
        halves.append(values[0, 0].mean() - values[1, 0].mean())
    assert np.sqrt(np.mean(np.square(halves))) / 2 == pytest.approx(np.std(means), rel=0.12)
    assert np.std(means) > 2 / np.sqrt(cycles * points) * np.sqrt(1 / (1 - 0.7**2))


@pytest.mark.parametrize("stated", [0.0, 2.5])
def test_a_distance_that_is_stated_is_that_before_the_record(stated: float, recorded: Path, tmp_path: Path) -> None:
    """Every piece began at it, however far the contact had slid since: even stating 0, the default, lost all wear of the record."""
    made = rig()
    before = replace(made, trials=(replace(made.trials[0], values={"sliding_distance": stated}),))
    said = write_experiment(before, tmp_path / "said", suffix=".parquet")
    distances = [
        [trial.values["sliding_distance"] for trial in compress_experiment(folder, samples=2000).experiment.trials]
        for folder in (recorded, said)
    ]
    assert distances[1] == pytest.approx([each + stated for each in distances[0]])
    assert np.ptp(distances[0]) > 1.0


def test_the_noise_that_is_stated_is_that_of_a_row(tmp_path: Path) -> None:
    """It was given to averages of some tens of them, and intervals were five times too wide."""
    made = rig()
    noisy = replace(made, trials=(replace(made.trials[0], noise_sd={"friction_force": 0.5}),))
    trials = compress_experiment(write_experiment(noisy, tmp_path / "noisy", suffix=".parquet"), samples=1000).experiment.trials
    stems = {Path(trial.file).stem for trial in trials}
    for trial in trials:
        stem = Path(trial.file).stem
        in_halves = {f"{stem[:-1]}a", f"{stem[:-1]}b"} <= stems
        assert bool(trial.noise_sd) != in_halves
        if trial.noise_sd:
            assert 0.05 < trial.noise_sd["friction_force"] <= 0.5
    assert any(stem.endswith("b") for stem in stems)


def vibration(folder: Path, column: FloatArray) -> Path:
    """A force sampled at 100 kHz, of a cut at 20 kHz."""
    signals = {CLOCK: Signal(CLOCK, "t", "s", None), "feed_force": Signal("feed_force", "F", "N", "output")}
    nominal = Nominal({"kinematics": "internal", "friction_law": "coulomb", "vibration_frequency": 20e3}, (), {})
    trial = Trial("cut.parquet", "c", {}, np.arange(column.size) / 1e5, {}, {"feed_force": column})
    return write_experiment(Experiment(Path(), "cut", "", nominal, signals, (trial,), None, ""), folder, suffix=".parquet")


def test_a_vibration_is_folded_by_its_own_clock(tmp_path: Path) -> None:
    """20 kHz sampled at 100 kHz: 5 rows of a cycle, 18 ppm faster than the recorder thinks, with harmonics that fold onto each other, a
    pause, and a force that grows. Each average cycle is the force at its time, at the phase that the record began with."""
    rate, true = 1e5, 20e3 * (1 + 18e-6)
    times = np.arange(400_000) / rate

    def force(phase: FloatArray, time: FloatArray) -> FloatArray:
        turns = 2 * np.pi * phase
        return np.asarray((5 + 3 * np.cos(turns - 0.4) + 1.5 * np.cos(2 * turns + 1) + 0.2 * np.sin(4 * turns)) * (1 + 0.05 * time))

    cutting = (times > 1.4) & ~((times > 2.5) & (times < 2.7))  # after the first batch of rows
    noise = 0.2 * np.random.default_rng(1).standard_normal(times.size)
    column = np.where(cutting, force(true * times, times), 0.0) + noise
    compressed = compress_experiment(vibration(tmp_path / "cut", column), MODEL, samples=2400)
    assert len(compressed.experiment.trials) >= 16
    for each in compressed.experiment.trials:
        time = each.times[0]
        assert cutting[int(rate * time)]
        error = each.outputs["feed_force"] - force(20e3 * each.times, np.full(each.times.size, time))
        assert np.sqrt(np.mean(error**2)) < 0.15  # of 5 N; of noise alone 0.02, of three thousandths of a cycle 0.12
        assert each.lead_in is not None
    distances = [each.values["sliding_distance"] for each in compressed.experiment.trials]
    assert distances == sorted(distances)
    assert distances[-1] > 0


def test_what_the_record_does_is_found() -> None:
    """Two programs, two holds and what lies between, to a cycle."""
    times, motion = program()
    seen = Overview([[times[:3500], motion[:3500]], [times[3500:], motion[3500:]]], 2, 1)
    course = stretches(seen, [1])
    assert [each.begin for each in course[1:]] == [each.end for each in course[:-1]]
    lasting = [(each.kind, each.begin / RATE, each.end / RATE) for each in course if each.kind != "transient"]
    assert [kind for kind, *_ in lasting] == ["repeating", "held", "repeating", "held"]
    edges = [edge for _, *edges in lasting for edge in edges]  # of repeating ones the first and last cycle are not theirs
    assert edges == pytest.approx([1.5, 20.5, 21.4, 24, 24.5, 33.5, 34.3, 36], abs=0.6)
    assert seen.ways(np.array([motion.size]))[0] == pytest.approx(np.sum(np.abs(motion)) / RATE, rel=1e-9)


def test_blocks_are_joined_once_there_are_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(overview, "MOST", 64)
    draw = np.random.default_rng(0)
    table = np.column_stack([np.arange(1000.0), draw.standard_normal(1000)])
    seen = Overview([list(part.T) for part in np.split(table, [7, 130, 500])], 2, None)
    assert (seen.block, seen.rows) == (16, 1000)
    assert seen.means == pytest.approx(table[:992].reshape(62, 16, 2).mean(axis=1), rel=1e-12)
    assert seen.times(np.array([-3.0, 0.0, 500.5, 999.0])) == pytest.approx([-3.0, 0.0, 500.5, 999.0])


def test_what_is_derived_batch_by_batch_is_what_is_derived_at_once(tmp_path: Path) -> None:
    """A velocity from a position, and a force less its inertia, across the edges of batches."""
    times = np.arange(3000) / 1e3
    toml = """format = 1
title = "axis"
nominal = { friction = "coulomb", kinematics = "external", mass = 2.0, values = { F_C = 3.0 } }
signals.time = { unit = "s" }
signals.slip_velocity = { column = "x", unit = "mm", role = "input", from = "position" }
signals.friction_force = { unit = "N", role = "output" }
trials = [{ file = "a.csv", condition = "a" }]
"""
    (tmp_path / "experiment.toml").write_text(toml)
    np.savetxt(tmp_path / "a.csv", np.column_stack([times, times, times]), header="time,x,friction_force", delimiter=",", comments="")
    document = read_document(tmp_path, MODEL)
    columns = trial_columns(document, document.trials[0], MODEL)
    by_name = {"time": times, "slip_velocity": 1e-3 * np.sin(9 * times), "friction_force": np.cos(times)}
    table = [by_name[column.name] for column in columns]
    at_once = derived("a.csv", columns, table, document)
    parts = [list(part) for part in zip(*(np.split(column, [400, 1500, 1510]) for column in table), strict=True)]
    by_batch = [np.concatenate(some) for some in zip(*derived_batches("a.csv", columns, parts, document), strict=True)]
    for one, other in zip(at_once, by_batch, strict=True):
        assert other == pytest.approx(one, abs=1e-9)


def test_the_command_says_what_it_did_and_its_folder_is_an_experiment(recorded: Path, tmp_path: Path) -> None:
    answer = CliRunner().invoke(app, ["experiment", "compress", str(recorded), "-o", str(tmp_path / "short"), "--samples", "1000"])
    assert answer.exit_code == 0, answer.output
    said = " ".join(answer.output.split())
    assert "long.parquet: 36 s, 9 000 rows became" in said
    assert "cycles averaged into" in said
    assert "2 stretches held still" in said
    read = read_experiment(tmp_path / "short", MODEL)
    made = compress_experiment(recorded, MODEL, samples=1000).experiment
    for one, other in zip(read.trials, made.trials, strict=True):
        assert dict(one.values) == dict(other.values)
        assert dict(one.noise_sd) == dict(other.noise_sd)
        assert one.outputs["friction_force"] == pytest.approx(other.outputs["friction_force"], rel=1e-12)
    assert read.setup_sd["friction_force"].clock == pytest.approx(1 / RATE)


def test_too_long_a_trial_is_compressed_unasked_and_the_answer_says_so(recorded: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read, said = read_or_compress(recorded, MODEL, samples=1000)
    assert (read.samples, said) == (ROWS, ())
    monkeypatch.setattr(compression, "LONG", ROWS - 1)
    read, told = read_or_compress(recorded, MODEL, samples=1000)
    assert read.samples < 2500
    assert told[0].startswith("long.parquet: 36 s, 9 000 rows became")
    assert read_or_compress(recorded, MODEL, samples=1000, whole=True)[0].samples == ROWS
    assert read_or_compress(recorded, MODEL, samples=1000, whole=True, most=50)[0].samples == 50


def test_what_cannot_be_compressed_is_said(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(ExperimentError, match="samples = 10: trials are compressed to 500 samples at least"):
        compress_experiment(recorded, MODEL, samples=10)
    short = vibration(tmp_path / "cut", np.random.default_rng(0).standard_normal(20_000))
    with pytest.raises(ExperimentError, match="nothing in its 20000 rows repeats itself for"):
        compress_experiment(short, MODEL)


def in_a_process(folder: Path, what: str) -> str:
    return subprocess.run([sys.executable, str(LONG_RECORD), str(folder), what], capture_output=True, text=True, check=True).stdout


@pytest.mark.campaign
@pytest.mark.skipif(sys.platform == "win32", reason="peak memory is asked of POSIX")
def test_ten_minutes_at_100_khz(tmp_path: Path) -> None:
    """60 million rows: compressed, identified and diagnosed as a whole, each in less than 1 GB, and in less than 3 minutes of a processor
    together; every value within four standard errors of the truth, and the wear of ten minutes named."""
    in_a_process(tmp_path / "rig", "60000000")
    compressed, identified, diagnosed = (json.loads(in_a_process(tmp_path / "rig", what)) for what in ("compress", "identify", "diagnose"))
    print(compressed, identified, diagnosed, sep="\n")
    assert "600 s, 60 000 000 rows became" in compressed["told"]
    for name, (value, sd) in identified["estimates"].items():
        assert abs(value - float(long_record.TRUTH[name])) < 4 * sd, name
        assert sd < 0.01 * abs(value), name
    assert (diagnosed["verdict"], diagnosed["effects"]) == ("effect", ["friction_wear"])
    assert max(each["peak"] for each in (compressed, identified, diagnosed)) < 1e9
    assert identified["seconds"] + diagnosed["seconds"] < 180
