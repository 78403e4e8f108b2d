"""What would orthogonal cutting tests measure on a contact whose parameters are known? Synthetic experiments, to see what comes back.

As in the paper's tests (section 4.1) the rake angle is 0, so that the friction force is the feed force; the slip velocity is given.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from evat import motions
from evat.experiment import Experiment, Nominal, Signal, Trial
from evat.experiment.document import CLOCK
from evat.model import FloatArray, ParameterError, nearest
from evat.models.simulate import simulate
from evat.motions import KINDS, Motion
from evat.native import kernel
from evat.paper.tables import materials, table_1
from evat.parameter_sets import softening_limit

TOP_SPEED = 1.0  # m/s, 60 m/min: ordinary in turning; guess, the paper states no test speeds
SPEEDS = (1 / 12, 1 / 6, 1 / 3, 2 / 3, 1.0)  # test speeds as shares of the top one
HEATS = (0.2, 0.6, 1.0)  # levels of the temperature proxy as shares of the top one
BELOW_LIMIT = 0.9  # of the speed at which eq. 7 of the paper stops to hold
TOLERANCE = 1e-6  # of the simulated truth: far below any noise
MOST_NOISE = 10.0
MOST_REPEATS = 1000
HEATED = ("temperature", "heated_presliding")
PROXIES = ("contact_temperature", "proxy_speed")


def uncertain() -> tuple[str, ...]:
    """What an identification sets out to find: the coefficients of the paper's table 1."""
    return tuple(cell.variable for cell in table_1(next(iter(materials()))))


def orthogonal(
    values: Mapping[str, float | str],
    effects: Sequence[str] = (),
    *,
    motion: str = "ramp",
    repeats: int = 3,
    noise: float = 0.01,
    seed: int = 0,
    rate: float = 1000.0,
    speeds: Sequence[float] | None = None,
    proxy: str = PROXIES[0],
    outputs: Sequence[str] = ("friction_force",),
    nominal_off: float = 0.3,
) -> Experiment:
    """Make an experiment whose truth is known: simulated tests of a contact, each motion repeated, with white noise.

    Parameters
    ----------
    values : mapping of str to float or str
        The truth, SI, by the component's names.
    effects : sequence of str
        Effects that are on in the truth.
    motion : str
        ramp (the paper's), steps, reversal, presliding, temperature or heated_presliding; see `evat.motions`.
    repeats : int
        Trials of each condition.
    noise : float
        Standard deviation over the root mean square of the output, over all trials.
    seed : int
        Of the noise and of the nominal values; the same seed gives the same experiment.
    rate : float
        Samples per second [Hz].
    speeds : sequence of float, optional
        Test speeds [m/s]; without them five up to 1 m/s, or up to where the paper's eq. 7 stops to hold.
    proxy : "contact_temperature" or "proxy_speed"
        The input that heated motions heat by.
    outputs : sequence of str
        What is measured.
    nominal_off : float
        The coefficients of the paper's table 1 that the truth names are off by up to that share in the nominal model; 0: it is the truth.

    Returns
    -------
    Experiment
        Its nominal model has the truth's effects; its nominal values are off.

    Raises
    ------
    ParameterError
        For a motion, number or name that is not allowed.
    SimulationError
        Where the truth does not run.

    Notes
    -----
    The paper, section 4.1: a rake angle of 0, so that the friction force is the feed force; the slip velocity is given.

    Examples
    --------
    >>> import evat
    >>> made = evat.orthogonal({"friction_law": "coulomb", "F_C": 3.0}, motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=200.0)
    >>> made.conditions, len(made.trials)
    (('speed 1', 'speed 2'), 4)
    """
    _check(motion, repeats, noise, rate, nominal_off, proxy, outputs)
    truth = truth_of(values, motion, proxy)
    numbers = kernel.check_values(truth, effects)
    held = {name: number for name, number in kernel.by_choice(numbers).items() if name not in effects}
    noise_seed, nominal_seed = np.random.SeedSequence(seed).spawn(2)
    clean = [(each, _simulated(each, truth, effects, outputs)) for each in _motions(motion, numbers, effects, speeds, proxy, rate)]
    trials = _noisy(clean, repeats, noise, np.random.default_rng(noise_seed), outputs)
    inputs = clean[0][0].inputs
    signals = {name: _signal(name) for name in (CLOCK, *inputs, *outputs)}
    nominal = _nominal(held, effects, nominal_off, np.random.default_rng(nominal_seed))
    return Experiment(Path(), f"Orthogonal cutting tests, simulated: {motion}", "", nominal, signals, trials, None, "")


def truth_of(values: Mapping[str, float | str], motion: str, proxy: str = PROXIES[0]) -> dict[str, float | str]:
    """The values with what the tests add to them: the law's name, and where motion and temperature come from."""
    known = kernel.variable("friction_law")
    truth: dict[str, float | str] = {known.name: known.choices[int(known.start)], **values, "kinematics": "external"}
    return truth | ({"proxy_source": proxy} if motion in HEATED else {})


def _check(motion: str, repeats: int, noise: float, rate: float, nominal_off: float, proxy: str, outputs: Sequence[str]) -> None:
    if motion not in KINDS:
        raise ParameterError(f"there is no motion {motion!r}; {nearest(motion, KINDS)}")
    if proxy not in PROXIES:
        raise ParameterError(f"proxy {proxy!r}: allowed are {', '.join(PROXIES)}.")
    if not 1 <= repeats <= MOST_REPEATS:
        raise ParameterError(f"repeats = {repeats}: 1 to {MOST_REPEATS} trials of each condition are needed.")
    if not 0 <= noise <= MOST_NOISE:
        raise ParameterError(f"noise = {noise:g}: a share of the force's root mean square is needed, 0 to {MOST_NOISE:g}.")
    if not 10 <= rate <= 1e6:
        raise ParameterError(f"rate = {rate:g} Hz: allowed is 10 Hz to 1 MHz.")
    if not 0 <= nominal_off < 1:
        raise ParameterError(f"nominal_off = {nominal_off:g}: a share from 0 to below 1 is needed.")
    wrong = [name for name in outputs if kernel.variable(name).causality != "output"]
    if wrong or not outputs:
        raise ParameterError(f"outputs {', '.join(wrong) or 'none'}: name outputs of the component, for example friction_force.")


def _motions(
    kind: str, values: Mapping[str, float], effects: Sequence[str], speeds: Sequence[float] | None, proxy: str, rate: float
) -> list[Motion]:
    bristle_length = max(_value(values, "F_C"), _value(values, "F_S")) / _value(values, "sigma0")
    softens = "thermal_softening" in effects
    top = min(TOP_SPEED, BELOW_LIMIT * softening_limit(values)) if softens else TOP_SPEED
    heated_by_slip = kernel.variable("proxy_source").choices[int(_value(values, "proxy_source"))] == "slip_speed"
    chosen = [share * (top if heated_by_slip else TOP_SPEED) for share in SPEEDS] if speeds is None else list(speeds)
    motions.check_speeds(chosen)
    if kind == "presliding":
        return motions.presliding(bristle_length, rate)
    if kind in HEATED:
        levels = [_proxy_input(share * top, proxy, values) for share in HEATS]
        lengths = [share * bristle_length for share in (motions.AMPLITUDES if kind == "heated_presliding" else (1.0,))]
        return motions.heated(levels, _proxy_input(0.0, proxy, values), proxy, lengths, chosen[::2] if kind == "temperature" else (), rate)
    return {"ramp": motions.ramp, "steps": motions.steps, "reversal": motions.reversal}[kind](chosen, rate)


def _proxy_input(theta: float, proxy: str, values: Mapping[str, float]) -> float:
    """The input that makes the temperature proxy `theta` [m/s]: itself, or T = T_amb + (T_ref - T_amb) (theta/theta_ref)^alpha_T."""
    if proxy == "proxy_speed":
        return theta
    ambient, reference = _value(values, "ambient_temperature"), _value(values, "reference_temperature")
    kelvin = ambient + (reference - ambient) * (theta / _value(values, "theta_ref")) ** _value(values, "alpha_T")
    return float(min(kelvin, kernel.variable(proxy).max))


def _value(values: Mapping[str, float], name: str) -> float:
    return values[name] if name in values else kernel.variable(name).start


def _simulated(motion: Motion, truth: Mapping[str, float | str], effects: Sequence[str], outputs: Sequence[str]) -> dict[str, FloatArray]:
    """What the sensors show without noise."""
    sensors = {name: sensor if (sensor := f"measured_{name}") in kernel.by_name() else name for name in outputs}
    values = {"relative_tolerance": TOLERANCE, **truth, **motion.values}
    trace = simulate(values, effects, times=motion.times, inputs=motion.inputs, outputs=tuple(sensors.values()))
    return {name: trace[sensor] for name, sensor in sensors.items()}


def _noisy(
    clean: Sequence[tuple[Motion, Mapping[str, FloatArray]]],
    repeats: int,
    noise: float,
    draw: np.random.Generator,
    outputs: Sequence[str],
) -> tuple[Trial, ...]:
    count = sum(motion.times.size for motion, _ in clean)
    sd = {name: noise * math.sqrt(sum(float(columns[name] @ columns[name]) for _, columns in clean) / count) for name in outputs}
    trials = []
    for place, (motion, columns) in enumerate(clean):
        for repeat in range(repeats):
            measured = {name: column + sd[name] * draw.standard_normal(column.size) for name, column in columns.items()}
            file = f"trials/{place + 1:02d}-{repeat + 1:02d}.csv"
            trials.append(Trial(file, motion.condition, motion.values, motion.times, motion.inputs, measured))
    return tuple(trials)


def _signal(name: str) -> Signal:
    if name == CLOCK:
        return Signal(name, "time [s]", "s", None)
    known = kernel.variable(name)
    return Signal(name, f"{name} [{known.unit}]", known.unit, "output" if known.causality == "output" else "input")


def _nominal(truth: Mapping[str, float | str], effects: Sequence[str], off: float, draw: np.random.Generator) -> Nominal:
    """The truth, with what is to be found off by up to that share, evenly; so the standard deviation is off/sqrt(3)."""
    values, relative_sd = dict(truth), {}
    for name in uncertain() if off else ():
        factor = 1 + off * draw.uniform(-1, 1)  # drawn for every name, so that one more or less leaves the others as they are
        if name in truth:
            known = kernel.variable(name)
            values[name] = min(max(factor * float(truth[name]), known.min), known.max)
            relative_sd[name] = off / math.sqrt(3)
    return Nominal(values, tuple(effects), relative_sd, initial_bristle="relaxed")  # each simulation begins at rest
