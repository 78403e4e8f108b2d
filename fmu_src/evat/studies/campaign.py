"""On which simulated cases is the diagnosis calibrated? Rigs, machines and ellipses drawn at random, run through the component itself.

Half of the cases are of the very form that is fitted. In the others the Stribeck curve has another exponent, and forces and gaps grow with
another power, as no effect makes them: what a real contact does otherwise. A gap is as large as its ratio to the noise says once the
nominal parameters have been refitted. Case after case is appended to a file, so that a campaign goes on where it was stopped; a case
depends on its number alone.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from evat.experiment import Experiment, Nominal, Trial
from evat.files.writing import as_output_error, usable
from evat.gap.calibrate import CalibrationCase
from evat.gap.compare import compare
from evat.gap.judgement import MISTUNED, NO_GAP, UNKNOWN, features
from evat.inference.parameters import Scales, amplitudes, shape_parameter, shapes
from evat.inference.prediction import Prediction
from evat.model import Effect, EvatError, FloatArray
from evat.models.contact import ContactModel
from evat.native.compile import kernel_library_path

KINDS = (NO_GAP, MISTUNED, "single", "single", "single", "pair", UNKNOWN)
RATIOS = (1.5, 4.0, 12.0)  # structural gap over noise
FORM_ERROR = 0.12  # what the form of a case is off by, in its gap (rms), in every other case
BENT = 0.15  # of the logarithm of a power, standard deviation: there, too
EXPONENT = (0.8, 2.6)  # of the Stribeck curve, there
CURVE = "lugre.stribeck_exponent"
BELIEF = 0.15  # usual prior standard deviation of a nominal parameter, of its value
EXACT = ("vibration_frequency", "width")  # known to whoever set them
FORMAT = 2  # of a line of the campaign's file
SAMPLES, CONDITIONS, REPEATS = 900, 4, 2


@dataclass(frozen=True)
class Drawn:
    """A rig without its noise: motions with the parameters of the truth, and what each output has."""

    experiment: Experiment
    truth: dict[str, float | str]


def draw_case(number: int, seed: int = 1) -> tuple[Experiment, str] | None:
    """The experiment with that number, and its truth; None where the effect that was drawn does nothing there."""
    draw = np.random.default_rng([seed, number])
    model, drawn = ContactModel(1), _rig(draw)
    prediction = Prediction(model, drawn.experiment)
    kind = KINDS[number % len(KINDS)]
    other_form = bool(number % 2) and kind != NO_GAP
    if other_form:
        drawn.truth[CURVE] = float(draw.uniform(*EXPONENT))
    clean = prediction.one(drawn.truth)
    level = float(np.sqrt(np.mean(clean**2)))
    noise = level * float(10 ** draw.uniform(-2.5, -1.5))
    ratio = RATIOS[(number // len(KINDS)) % len(RATIOS)]
    left = _refit(prediction, drawn)
    gap, strange, truth = np.zeros_like(clean), None, kind
    if kind in ("single", "pair"):
        drawn_effects = _effects(draw, prediction, drawn, 1 if kind == "single" else 2, ratio * noise, left)
        if drawn_effects is None:
            return None
        gap, names = drawn_effects
        truth = "+".join(sorted(names))
    elif kind == UNKNOWN:
        strange = _Stranger(int(draw.integers(3)), float(draw.uniform(0.02, 0.12)), ratio * noise, bool(draw.integers(2)))
    if other_form:
        gap = _bent(draw, prediction, gap)
        other = left((_bent(draw, prediction, clean) - clean)[None])[0]
        gap = gap + other * (FORM_ERROR * max(ratio * noise, 0.02 * level) / float(np.sqrt(np.mean(other**2)) + 1e-12))
    nominal = {name: value for name, value in drawn.truth.items() if name != CURVE}
    sd = {name: float(draw.uniform(0.05, 0.25)) for name, value in nominal.items() if isinstance(value, float) and name not in EXACT}
    if kind != NO_GAP:
        for name, share in sd.items():
            nominal[name] = float(drawn.truth[name]) * math.exp(share * float(draw.normal()))
    return _measured(draw, prediction, clean + gap, noise, nominal, sd, strange), truth


def _refit(prediction: Prediction, drawn: Drawn) -> Callable[[FloatArray], FloatArray]:
    """What a refit of the nominal parameters leaves of a change of the outputs, (K, N) -> (K, N), as far as they are linear."""
    scales = {name: BELIEF * value for name, value in drawn.truth.items() if isinstance(value, float) and name not in (*EXACT, CURVE)}
    _, slopes = prediction.jacobian(drawn.truth, list(scales), scales)
    basis, sizes, _ = np.linalg.svd(slopes, full_matrices=False)
    basis = basis[:, sizes > 1e-3 * sizes.max()]
    return lambda change: np.asarray(change - (change @ basis) @ basis.T, dtype=np.float64)


def _bent(draw: np.random.Generator, prediction: Prediction, row: FloatArray) -> FloatArray:
    """A row (N,) that grows with another power of itself, each channel in its own rms."""
    bent, power = row.copy(), math.exp(BENT * float(draw.normal()))
    for channel in prediction.channels:
        own = prediction.places(channel)
        level = float(np.sqrt(np.mean(row[own] ** 2)))
        if level > 0:
            bent[own] = level * np.sign(row[own]) * np.abs(row[own] / level) ** power
    return bent


def _rig(draw: np.random.Generator) -> Drawn:
    """A reciprocating rig, a driven contact with its chip, or the ellipse."""
    kind = int(draw.integers(3))
    force, trials = float(10 ** draw.uniform(0.3, 1.7)), list[Trial]()
    law: dict[str, float | str] = {
        "friction_law": "lugre",
        "F_C": force,
        "F_S": force * float(draw.uniform(1.0, 1.6)),
    }
    if kind == 2:
        law |= {"kinematics": "internal", "vibration_frequency": 2e4, "sigma0": force / 1e-6, "sigma1": 1e-2 * force, "sigma2": 0.1 * force}
        law |= {"v_s": float(10 ** draw.uniform(-2.3, -1)), "shear_stress": float(draw.uniform(2e8, 6e8)), "width": 1e-3}
        times = np.arange(SAMPLES) / (2e4 * 60)
        for place, speed in enumerate(np.linspace(0.08, 0.4, CONDITIONS)):
            outputs = {name: np.zeros(SAMPLES) for name in ("principal_force", "feed_force")}
            trials.append(Trial(f"{place}", f"c{place}", {"cutting_speed": float(speed)}, times, {}, outputs))
    else:
        frequency, speed = float(10 ** draw.uniform(0, 2)), float(10 ** draw.uniform(-3, -0.5))
        law |= {"kinematics": "external", "v_s": speed * float(10 ** draw.uniform(-1.5, -0.3)), "proxy_source": "proxy_speed"}
        law |= {"sigma0": force / (speed / frequency * float(10 ** draw.uniform(-2.5, -1))), "sigma2": 0.3 * force / speed}
        law["sigma1"] = 0.1 * force / speed * float(10 ** draw.uniform(-2, -0.3))
        times = np.arange(SAMPLES) / (frequency * SAMPLES / 6)
        for place, share in enumerate(np.geomspace(0.25, 1.0, CONDITIONS)):
            wave = 2 * np.pi * frequency * times
            velocity = speed * share * (np.sin(wave) + 0.3 * place * np.sin(2.4 * wave + place))
            slow = 0.5 + 0.4 * np.sin(wave / (2.3 + place))
            inputs = {"slip_velocity": velocity, "proxy_speed": speed * slow, "normal_load": 10 * (1 + 0.3 * np.cos(wave / 3.1))}
            names: tuple[str, ...] = ("friction_force",)
            if kind == 1:
                inputs["uncut_thickness"] = 1e-4 * (0.6 + 0.5 * np.sin(wave + 1))
                names = ("friction_force", "principal_force", "feed_force")
            trials.append(Trial(f"{place}", f"c{place}", {}, times, inputs, {name: np.zeros(SAMPLES) for name in names}))
        if kind == 1:
            law |= {"shear_stress": 10 * force / (1e-3 * 1e-4), "width": 1e-3}
    return Drawn(Experiment(Path(), f"case of rig {kind}", "", Nominal(law, (), {}), {}, tuple(trials), None, ""), law)


def _effects(
    draw: np.random.Generator,
    prediction: Prediction,
    drawn: Drawn,
    count: int,
    size: float,
    left: Callable[[FloatArray], FloatArray],
) -> tuple[FloatArray, tuple[str, ...]] | None:
    """Contributions (N,) of effects drawn at random, each made to leave about as much as asked [N rms], and their names."""
    given = drawn.experiment.given
    offered = [e for e in prediction.model.effects if not prediction.model.missing_inputs([e.name], drawn.truth, given)]
    clean, total, names = prediction.one(drawn.truth), np.zeros(prediction.measured.size), list[str]()
    for _ in range(30):
        effect = offered[int(draw.integers(len(offered)))]
        if effect.name in names or any(name in effect.rivals for name in names):
            continue
        sized = _sized(draw, prediction, drawn, effect, size, clean, left)
        if sized is not None:
            total, names = total + sized, [*names, effect.name]
            if len(names) == count:
                return total, tuple(names)
    return None


def _sized(
    draw: np.random.Generator,
    prediction: Prediction,
    drawn: Drawn,
    effect: Effect,
    size: float,
    clean: FloatArray,
    left: Callable[[FloatArray], FloatArray],
) -> FloatArray | None:
    scales = Scales(prediction.model, drawn.experiment)
    values: dict[str, float | str | FloatArray] = dict(drawn.truth)
    for variable in shapes(effect):
        known = shape_parameter(variable, scales)
        values[variable.name] = known.value(float(np.clip(draw.normal(), -1.5, 1.5)))
    own = amplitudes(effect)
    chosen = own[int(draw.integers(len(own)))]
    sign = -1.0 if chosen.min < chosen.neutral and draw.random() < 0.5 else 1.0
    tried = np.clip(chosen.neutral + sign * scales.amplitude(chosen) * 10 ** np.arange(-4.0, 4.0, 0.5), chosen.min, chosen.max)
    values |= {v.name: v.neutral for v in own if v is not chosen}
    change = prediction.many({**values, chosen.name: tried}, (effect.name,)) - clean
    sizes = np.sqrt(np.mean(left(np.nan_to_num(change)) ** 2, axis=1))
    good = np.all(np.isfinite(change), axis=1) & (sizes > 0.5 * size) & (sizes < 3 * size)
    if not np.any(good):
        return None
    place = int(np.flatnonzero(good)[np.argmin(np.abs(np.log(sizes[good] / size)))])
    row: FloatArray = change[place]
    return row


@dataclass(frozen=True)
class _Stranger:
    """What no effect is, of some rms [N]: a line at a frequency of its own, a sawtooth, or spikes; in every repeat the same, or anew."""

    kind: int
    rate: float  # per sample
    size: float
    anew: bool

    def row(self, samples: int, phase: float) -> FloatArray:
        n = np.arange(samples)
        line = np.sin(2 * np.pi * self.rate * n + phase)
        tooth = np.mod(0.3 * self.rate * n + phase, 1.0) - 0.5
        spikes = (np.mod(0.5 * self.rate * n + phase, 1.0) < 0.06) * 1.0
        shape = (line, tooth, spikes)[self.kind]
        row: FloatArray = self.size * shape / float(np.sqrt(np.mean(shape**2)) + 1e-12)
        return row


def _measured(
    draw: np.random.Generator,
    prediction: Prediction,
    clean: FloatArray,
    noise: float,
    nominal: dict[str, float | str],
    sd: Mapping[str, float],
    strange: _Stranger | None,
) -> Experiment:
    """Repeats with coloured noise; gain, zero and clock differ a little from one to the next."""
    colour, trials = float(draw.uniform(0, 0.7)), list[Trial]()
    for place, trial in enumerate(prediction.experiment.trials):
        phase = float(draw.uniform(0, 2 * np.pi))
        for repeat in range(REPEATS):
            phase = float(draw.uniform(0, 2 * np.pi)) if strange and strange.anew else phase
            outputs = {}
            for segment in prediction.segments:
                if segment.trial != place:
                    continue
                row = clean[segment.at]
                white = draw.normal(size=row.size + 50)
                for n in range(1, white.size):
                    white[n] += colour * white[n - 1]
                late = float(draw.normal()) * 0.1 * (trial.times[1] - trial.times[0])
                moved = np.interp(trial.times - late, trial.times, row) + (strange.row(row.size, phase) if strange else 0.0)
                outputs[segment.channel] = moved * (1 + 0.003 * draw.normal()) + noise * (
                    0.1 * draw.normal() + white[50:] * math.sqrt(1 - colour**2)
                )
            trials.append(replace(trial, file=f"{trial.file}{repeat}", outputs=outputs))
    values = Nominal(nominal, (), {**sd, **dict.fromkeys(EXACT, 0.0)})
    return replace(prediction.experiment, nominal=values, trials=tuple(trials))


def run_case(number: int) -> str:
    """A line of the campaign's file: the case's number, and what the judgement sees of it (nothing where there was no case)."""
    try:
        drawn = draw_case(number)
        if drawn is None:
            return _line({"number": number})
        experiment, truth = drawn
        case = CalibrationCase(features(compare(Prediction(ContactModel(1), experiment))), truth)
        return _line({"number": number, "case": case.line()})
    except EvatError as error:
        return _line({"number": number, "error": str(error)[:200]})


@functools.cache
def kernel_digest() -> str:
    """The kernel through which cases are run: those of another one are other cases."""
    return hashlib.sha256(kernel_library_path().read_bytes()).hexdigest()[:16]


def _line(entry: Mapping[str, Any]) -> str:
    text = json.dumps({**entry, "kernel": kernel_digest(), "format": FORMAT}, sort_keys=True)
    return json.dumps({"digest": hashlib.sha256(text.encode()).hexdigest()[:16], "entry": text})


def _entry(line: str) -> Mapping[str, Any] | None:
    """What a line says; None where it is cut off, damaged, of another kernel or of another format."""
    try:
        held = json.loads(line)
        text, digest = str(held["entry"]), held["digest"]
        entry: dict[str, Any] = json.loads(text)
        return (
            entry
            if hashlib.sha256(text.encode()).hexdigest()[:16] == digest and (entry["kernel"], entry["format"]) == (kernel_digest(), FORMAT)
            else None
        )
    except (ValueError, KeyError, TypeError, RecursionError):
        return None


def campaign(path: Path, count: int, workers: int, tell: Callable[[int], None] | None = None) -> Iterator[CalibrationCase]:
    """Cases 0 to count - 1; those that the file does not have whole, and run through this kernel, are run and appended to it."""
    text = path.read_text(encoding="utf-8", errors="replace") if path.is_file() else ""
    entries = [entry for line in text.splitlines() if (entry := _entry(line)) is not None]
    kept, whole = {entry["number"]: entry for entry in entries}, text.endswith("\n") or not text
    missing = [number for number in range(count) if number not in kept]
    usable(path.parent)
    with ProcessPoolExecutor(workers) as pool:
        for number, line in zip(missing, pool.map(run_case, missing), strict=True):
            with as_output_error(path, "the case"), path.open("a", encoding="utf-8") as file:
                file.write(line + "\n" if whole else "\n" + line + "\n")
            kept[number], whole = _entry(line) or {}, True
            if tell:
                tell(len(kept))
    for number in range(count):
        if "case" in kept[number]:
            yield CalibrationCase.read(kept[number]["case"])


def numbers(cases: Sequence[CalibrationCase]) -> dict[str, int]:
    """How many cases of each kind."""
    counts: dict[str, int] = {}
    for case in cases:
        kind = case.truth if case.truth in (NO_GAP, MISTUNED, UNKNOWN) else "pair" if "+" in case.truth else "single"
        counts[kind] = counts.get(kind, 0) + 1
    return counts
