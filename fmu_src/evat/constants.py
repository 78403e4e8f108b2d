"""Which numbers does a diagnosis go by that no record tells? All of them: value, unit, meaning, and where each comes from.

Smoothing of records, inference and diagnosis take their numbers from here by name, when they use them, so that a campaign replaces one at a
time (`CONSTANTS.replaced`). What half and twice each does to a stored set of cases stands in evat/gap/verdict/sensitivity.json.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Generic, Literal, TypeVar, overload

from evat.model import ParameterError

Number = int | float
Value = Number | tuple[int, ...] | tuple[float, ...]
Held = TypeVar("Held", bound=Value)
Origin = Literal["derived", "calibrated", "guess"]


class Constant(Generic[Held]):
    """One number, or several that go together.

    origin : derived (it follows from something, which `source` names), calibrated (fitted to simulated cases: `value` is where the fit
    began), or guess (reasoned, and tried on a few cases); low, high : the values between which it makes sense. A guess to which answers
    should not react says in `source` why it is there: a safety limit, a numerical tolerance, a budget of work.
    """

    def __init__(
        self,
        value: Held,
        unit: str,
        meaning: str,
        *,
        origin: Origin = "guess",
        source: str = "",
        low: float = float("-inf"),
        high: float = float("inf"),
    ) -> None:
        self.name = ""
        self.value, self.unit, self.meaning, self.origin, self.source, self.low, self.high = value, unit, meaning, origin, source, low, high

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, table: None, owner: type) -> Constant[Held]: ...

    @overload
    def __get__(self, table: ConstantTable, owner: type) -> Held: ...

    def __get__(self, table: ConstantTable | None, owner: type) -> Constant[Held] | Held:
        if table is None:
            return self
        return table.now(self.name, self.value)

    def times(self, factor: float, value: Value | None = None) -> Value:
        """So many times its value (or `value` in place of it), within its bounds; a count stays one, and is at least 1."""

        def one(number: Number) -> Number:
            wanted = min(max(number * factor, self.low), self.high)
            return max(int(wanted), 1) if isinstance(number, int) else wanted

        value = self.value if value is None else value
        return tuple(map(one, value)) if isinstance(value, tuple) else one(value)


class ConstantTable:
    """Every number as an attribute: `CONSTANTS.plausible_effect`. `replacements` are those that do not have their declared value now."""

    def __init__(self) -> None:
        self.replacements: Mapping[str, Value] = MappingProxyType({})
        self.readers: tuple[Callable[[str], object], ...] = ()

    def declared(self) -> dict[str, Constant[Value]]:
        """By name, as they are declared."""
        return {name: each for name, each in vars(type(self)).items() if isinstance(each, Constant)}

    def now(self, name: str, value: Held) -> Held:
        """What a constant of this value is now: what it was replaced by, else that."""
        for reader in self.readers:
            reader(name)
        return self.replacements.get(name, value)  # type: ignore[return-value]

    @contextmanager
    def replaced(self, **values: Value) -> Iterator[None]:
        """With other values, for all threads of this process, until the block ends."""
        declared = self.declared()
        for name, value in values.items():
            if name not in declared:
                raise ParameterError(f"constant {name!r}: there is none of that name; evat.constants lists them.")
            if isinstance(value, tuple) != isinstance(declared[name].value, tuple):
                raise ParameterError(f"constant {name} = {value!r}: it is of the form {declared[name].value!r}.")
        before, self.replacements = self.replacements, MappingProxyType({**self.replacements, **values})
        try:
            yield
        finally:
            self.replacements = before

    @contextmanager
    def reading(self) -> Iterator[set[str]]:
        """The names of the constants that are read until the block ends: no other can have had a say in what was done there."""
        names = set[str]()
        with self.told_before_reading(names.add):
            yield names

    @contextmanager
    def told_before_reading(self, reader: Callable[[str], object]) -> Iterator[None]:
        """`reader` is given the name of each constant just before it is read; what it replaces then counts already."""
        before, self.readers = self.readers, (*self.readers, reader)
        try:
            yield
        finally:
            self.readers = before


class _Constants(ConstantTable):
    """In the order of a diagnosis: recorded inputs, predictions, noise, whitening, fits, search, judgement, what is told."""

    # Whether the records can be compared at all
    fewest_samples = Constant(30, "samples", "below which, and below fewest_means, nothing is claimed", source="safety limit")
    fewest_means = Constant(4, "means", "below which, and below fewest_samples, nothing is claimed", source="safety limit")
    samples_per_cycle = Constant(6, "samples", "of a vibration cycle, below which its phase is not seen; asked of tools that vibrate")
    least_variation = Constant(0.02, "of its size", "an input that changes by less does not vary")
    visible_change = Constant(5.0, "sd", "of all samples together, below which a change by an effect cannot be seen", source="safety limit")
    saturated_share = Constant(
        0.001, "of the samples", "at the end of a sensor's range, above which it is saturated", high=1.0, source="safety limit"
    )
    saturation_level = Constant(0.999, "of full scale", "from which on a sensor is at the end of its range", high=1.0)
    solver_error_limit = Constant(0.5, "of the noise", "numerical error above which nothing is claimed", source="safety limit")
    opposed_correlation = Constant(
        -0.5, "1", "correlation of measured and simulated below which a sign is turned", origin="derived", low=-1.0,
        source="the right sign would take a lag of more than 120 degrees, the wrong one noise of three times the power of the force",
    )  # fmt: skip
    wrong_unit_ratio = Constant(
        300.0, "1", "rms of measured over simulated, or its inverse, from which a unit is wrong", low=1.0,
        source="static friction alone can be off by 80 times",
    )  # fmt: skip
    visible_solver_error = Constant(
        1e-3, "of the rms of a channel", "a numerical error that is less keeps nothing from being claimed", source="numerical tolerance"
    )
    clock_gap = Constant(
        100.0, "median sample steps", "a record that goes on after such a gap is two records", low=1.0, source="safety limit"
    )
    sure_error = Constant(2.0, "sd", "by which an error of the set-up is not 0, from which on it is to be put right")
    notable_error = Constant(0.5, "of the noise", "that such an error changes, from which on it is to be put right")
    finest_step = Constant(
        1e-12, "of the usual step", "of a clock, below which no clock tells two samples apart", source="numerical tolerance"
    )
    clipped_share = Constant(0.005, "of the samples", "at one end of all values, from which a recording is told to be clipped", high=1.0)
    mostly_clipped = Constant(0.1, "of the samples", "the same, from which nothing is judged by it", high=1.0)
    next_level = Constant(0.02, "of the range", "within which the next value lies, of a recording that is clipped: else it has two states")
    fewest_clipped = Constant(20, "samples", "at one value, that may be clipped")
    piled_up = Constant(3.0, "1", "times as many samples at the last value as at the next one", low=1.0)
    far_from_nominal = Constant(
        0.5, "of the rms", "what a nominal model leaves, from which units and places of channels are doubted", low=0.1
    )
    near_to_nominal = Constant(0.35, "of the rms", "what it leaves at most with a column declared otherwise", high=1.0)
    nearer_by_declaration = Constant(4.0, "1", "times as much it leaves as the column is declared", low=1.0)
    clearly_alike = Constant(0.5, "1", "correlation of a recording with the model, to either side, that is no accident", high=1.0)
    late_samples = Constant(5, "samples", "by which repeats may be out of step and are compared all the same")
    alike_once_moved = Constant(0.9, "1", "correlation of two repeats that are one motion, moved", high=1.0)
    farthest_moved = Constant(0.25, "of their length", "by which repeats may be out of step and are still one motion", high=1.0)
    nearer_once_moved = Constant(0.5, "of what is missing from a correlation of 1", "with a repeat, and with the model, that is left then")
    later_gap = Constant(
        1.3,
        "of the root mean square",
        "that samples which were not looked at leave, over that of those that were: something changes there",
        low=1.0,
    )
    diagnosed_samples = Constant(
        8_000, "samples", "that are simulated at most in one run of all trials; repeats of a run count once", source="budget of work"
    )

    # Recorded inputs
    white_third_differences = Constant(
        -0.5, "1", "correlation of neighbouring third differences below which they are noise", origin="derived", low=-1.0,
        source="white noise has -0.75, a motion about 1",
    )  # fmt: skip
    lost_samples = Constant(1.5, "usual steps of a clock", "and more are no step: samples were lost", source="safety limit", low=1.0)
    fewest_input_samples = Constant(16, "samples", "of a recorded column whose noise or quantum is looked at", source="safety limit")
    least_input_noise = Constant(
        1e-6, "of half the range", "noise of a recorded column that is less is rounding", source="numerical tolerance"
    )
    quantised_share = Constant(
        0.99, "of the differences", "whole multiples of the smallest, where a position was counted, as by an encoder", high=1.0
    )
    quantum_error = Constant(0.05, "quanta", "so far may a difference of a counted position be from a whole multiple", high=0.5)
    largest_quantised_difference = Constant(
        1e3, "quanta", "above which, for the median, the smallest difference of a position is no quantum"
    )
    least_quantum = Constant(1e-9, "of half the range", "a difference of a position that is less is rounding")
    smoothing_windows = Constant((1, 2, 4, 8, 16, 32, 64, 128), "samples", "to each side of the middle one, of local polynomials")
    smoothing_confidence = Constant(2.5, "sd", "of the intervals that have to meet")
    sample_confidence = Constant(4.0, "sd", "of the interval of a sample by itself: further from it a smoothed column cuts a corner")
    exact_window = Constant(5, "samples", "of the polynomial through all of them that differentiates a position without noise", low=3)
    as_sure = Constant(1e-9, "of the standard deviation", "two estimates that differ by less are as sure", source="numerical tolerance")
    mass_sd = Constant(0.05, "of the stated mass", "how far that of what moves may be off", source="catalogues, and what is clamped on")
    unstated_inertia = Constant(0.03, "of the rms of the force", "that of what moves between contact and sensor, where no mass is stated")
    evidence_of_mass = Constant(60.0, "log evidence", "from which one moves; what else follows the acceleration gives up to 45")
    largest_inertia = Constant(0.5, "of the rms of the force", "the same at most", low=0.0, source="safety limit")
    largest_mass = Constant(3.0, "of the stated mass", "that more may move at most", low=0.0, source="safety limit")
    alike_inputs = Constant(1.5, "of the noise of both", "how far apart two recordings of one motion may be, root mean square", low=1.0)
    clock_jitter = Constant(1e-3, "samples", "clocks that differ by less are one", source="numerical tolerance")
    clock_together = Constant(0.05, "samples", "samples of repeats of a vibrating tool that differ by less were taken together")
    largest_lag = Constant(0.25, "of a recording", "by which repeats may be out of step", high=0.5)
    lag_tie = Constant(0.1, "of the least mean square", "by which motions that are so many samples apart may agree less and are as likely")
    lag_rounding = Constant(1e-9, "of the mean square", "below which motions are the same", origin="derived", source="rounding of sums")
    as_much_compared = Constant(
        0.9, "of the samples", "that repeats share in another way: of such ways that in which they agree best", source="numerical tolerance"
    )
    in_step = Constant(0.02, "of the rms", "by which repeats that follow one motion differ at most once they are in step")
    perturbation_seed = Constant(20240301, "1", "of the noise by which inputs are perturbed")
    alike_cycles = Constant(1e-3, "of an input's variance", "cycles that differ by less are the same cycle", source="numerical tolerance")

    # Predictions and parameters
    derivative_step = Constant(
        1e-3, "of a parameter, in its scale", "small against its curvature, large against the noise of runs at solver_tolerance"
    )
    derivative_step_across_jumps = Constant(
        0.1,
        "of a parameter, in its scale",
        "the same in a search where jumps of the force move through samples: some of these pass in each step",
    )
    steepest_slope = Constant(
        100.0, "of the largest number measured", "by which one prior sd of a parameter changes a prediction at most", low=1.0
    )
    solver_tolerance = Constant(1e-5, "1", "relative tolerance of runs whose differences are taken", low=1e-9, source="numerical tolerance")
    solver_tolerance_of_records = Constant(
        1e-4,
        "1",
        "the same in a search, and in a diagnosis of records, whose many samples tell slopes within some per cent; means do not",
        low=1e-9,
    )
    law_shape_sd = Constant(
        0.5, "of the logarithm", "prior standard deviation of a shape of the base law: Stribeck exponents of 0.5 to 4 were published"
    )
    usual_form = Constant(
        0.5, "1", "prior probability that a shape of the base law, or its form as a whole, is exactly the textbook's", high=0.99
    )
    clock_shift = Constant(0.5, "samples", "over which the derivative to a clock is taken: a jump has none")
    tried_clocks = Constant(33, "1", "clocks that are tried of each channel where a model moves by itself", source="budget of work", low=3)
    searches_of_clocks = Constant(2, "1", "of which each begins where the one before and a fit have led to", source="budget of work", low=1)
    least_gain_of_clock = Constant(0.05, "of the mean square", "that a clock has to take away to be held")
    least_drift = Constant(0.02, "samples", "over a recording: a clock that drifts by less shows nowhere, not in steep reversals")
    widest_setup_error = Constant(2.0, "sd", "what is further off is no tolerance of a set-up any more")

    least_form = Constant(0.05, "of accuracy_of_laws", "a form of a law that does less shows nowhere", high=1.0)
    samples_of_a_cycle = Constant(
        241, "samples", "of a cycle whose means were taken, by which forms of a cut are told", source="budget of work", low=3
    )
    widest_form = Constant(2.5, "sd", "by which a force differs more is no form of its law any more")

    least_rest = Constant(0.03, "of a recording", "in a row that is flat and near 0 is rest")
    fewest_rest_samples = Constant(5, "samples", "of rest, that tell of a zero")
    nearest_rest = Constant(2.0, "of the widest zero", "a velocity that is further from 0 is no rest")
    flat_rest = Constant(0.5, "of the widest zero", "the velocity may range over so much at rest")
    noise_at_rest = Constant(4.0, "sd", "of its noise: a velocity that is no further from what it reads at rest, for a while, is rest")
    rest_before_creep = Constant(1.01, "times what is left", "by a contact that creeps: one that rests is taken for as good")
    zeros_tried = Constant(9, "values", "of the zero of a velocity, before it enters linearly")

    # How bristles were bent at the start
    settling_speeds = Constant(
        (0.01, 0.032, 0.1, 0.32, 1.0), "of the largest slip velocity", "slowly enough for static friction, fast enough to settle"
    )
    sure_start = Constant(4.0, "sd", "from relaxed: less may be chance")
    least_start = Constant(0.02, "of the steady deflection", "less shows nowhere")
    widest_start = Constant(
        1.5, "of the steady deflection", "no bristle is bent further, whatever a mis-tuned model asks for", source="safety limit"
    )

    rate_of_start = Constant(0.25, "e-folds", "by which an unknown start dies away faster or slower than one model has it (sd)")
    least_samples_per_end = Constant(8, "samples", "of a recording, one of which may be unsure at either end", source="safety limit")

    # Noise
    most_lags = Constant(24, "samples", "of an autoregression: a slow noise beside a white one goes by many", source="budget of work")
    usual_lags = Constant(6, "samples", "of it at most where recordings are short")
    samples_per_lag = Constant(20, "samples", "for each coefficient of an autoregression; from fewer none is estimated")
    samples_of_own_noise = Constant(
        100, "samples", "from which what a fit leaves of one recording tells the size of its noise, to 7 %", source="safety limit"
    )
    clipped_at = Constant(4.0, "robust sd", "beyond which a sample counts as no more than that")
    calm_window = Constant(24, "samples", "less a parabola: what a model lacks bends more slowly", low=8)
    calm_quantile = Constant(0.25, "of the windows", "by their mean square, which tell what is calm", low=0.0, high=1.0)
    calm_squares = Constant(2.0, "of their mean square", "up to which a window is calm", low=1.0)
    fewest_calm_windows = Constant(16, "windows", "of fewer the correlation of noise is not told", source="safety limit")
    heavy_tails = Constant(2.5, "standard errors", "of the excess kurtosis of changes of a level, beyond which they are none of noise")
    jump_of_prediction = Constant(0.5, "of its range in a recording", "within a window: by more, repeats out of step differ by that")
    calm_deviations = Constant(2.0, "over the root of the windows", "log mean square that these may be off by", low=0.0)
    memory_of_sensors = Constant(
        (-0.5, 0.8), "lag-one correlation", "of the noise of a sensor, at least and at most; what is smoother may be what a model lacks"
    )
    windows_per_cycle = Constant(5, "windows", "a motion that comes back in fewer leaves none of them calm", low=1.0)
    fewest_cycles = Constant(3, "cycles", "of a fast motion in a recording, that tell what comes back with it from noise", low=2.0)
    least_clear_share = Constant(
        0.25, "of the samples", "that stand beside no jump, from which those tell the size of noise", source="safety limit"
    )
    samples_per_amplitude = Constant(
        8, "samples", "for each amplitude of what comes back with a motion and changes slowly", low=2, source="budget of work"
    )
    burst_samples = Constant(5, "samples", "a burst fills most of so many")
    burst_height = Constant(7.0, "robust sd of medians", "beyond which they are a burst; noise reaches 5")
    line_height = Constant(40.0, "of the spectrum around", "beyond which it is a line; noise reaches 15")
    most_lines = Constant(
        4, "1", "lines that are taken out of what repeats do not share before its noise is estimated", source="safety limit"
    )
    wander_periods = Constant(8, "periods in a recording", "as slow as those, and what repeats do not share may be wander")
    wander_samples = Constant(256, "samples of a recording", "some so many tell the memory of its noise, as far as slow periods show it")
    wander_height = Constant(3.0, "of what noise would hold there", "beyond which it is; chance reaches 2", low=1.0)
    memory_deviations = Constant(1.64, "sd", "the memory of noise may be longer by, where slow periods are judged: one-sided 95 %")
    smooth_differences = Constant(0.3, "1", "lag-one correlation of differences that no noise with a memory has: it is 0 at most", high=1.0)
    least_wander = Constant(0.01, "of the rms", "less every rig has")
    unequal_noise = Constant(2.0, "times the quietest condition's rms", "noise of one rig reaches 1.7", low=1.0)
    unequal_memory = Constant(0.3, "1", "more lag-one correlation than there: noise that is only larger has no other spectrum", low=0.0)
    fewest_regular_samples = Constant(60, "samples", "of a recording that is searched for bursts and lines", source="safety limit")
    tone_samples = Constant(64, "samples", "of a stretch in which a tone is looked for", low=16)
    slowest_tone = Constant(4, "periods", "in such a stretch, below which it is a level that wanders")
    tone_height = Constant(20.0, "of the broad band", "square of a tone that stands out of it", low=1.0)
    fewest_recordings_of_a_tone = Constant(3, "recordings", "in which a tone stands out, that is no accident", low=2)
    prior_trials = Constant(2.0, "repeats", "what the priors of the random effects between trials weigh")
    prior_trial_gain = Constant(0.003, "1", "gain between trials, a priori (sd)")
    prior_trial_zero = Constant(0.003, "of the rms", "zero between trials, a priori (sd)")
    prior_trial_clock = Constant(0.1, "samples", "clock between trials, a priori (sd)")
    clear_difference = Constant(4.0, "sd", "of noise, from which on gain, zero or clock of a repeat is told though noise hides usual ones")
    largest_difference = Constant(100.0, "of what is usual", "gain, zero or clock of a repeat: a set-up that is off by more is no repeat")
    no_signal = Constant(1e-100, "1", "a column that is smaller is none", origin="derived", source="its square is still a number")
    least_told_apart = Constant(
        1e-5, "of the largest", "singular value of gain, zero and clock of a repeat, below which a force is too steady to tell them apart",
        source="numerical tolerance",
    )  # fmt: skip
    shortest_repeat = Constant(8, "samples", "of fewer, three are gone with gain, zero and clock", low=4, source="safety limit")
    usual_noise_of_means = Constant(
        0.01, "of the rms", "noise of a mean for which nobody stated it", source="dynamometer means repeat to 0.3 to 3 %"
    )
    noise_of_means_sd = Constant(1.0, "e-folds", "prior standard deviation of that noise")
    smooth_size_range = Constant((1e-3, 1.0), "of the rms", "of what varies smoothly from mean to mean")
    smooth_sizes = Constant(10, "1", "sizes that are tried in that range")
    smooth_length_range = Constant((0.3, 3.0), "of the range of each condition", "over which that varies")
    smooth_lengths = Constant(5, "1", "lengths that are tried in that range")
    nugget_range = Constant((2e-4, 0.2), "of the rms", "of the noise of means")
    nuggets = Constant(24, "1", "noises of means that are tried in that range")
    logarithmic_range = Constant(10.0, "1", "largest over smallest value of a condition, from which on it counts by its logarithm", low=1.0)

    # The frequency of a vibration
    cycles_to_see_a_frequency = Constant(
        3.0, "cycles", "of a recording, from which on it tells at which frequency a force comes back", low=1.0
    )
    frequency_harmonics = Constant(4, "1", "of a cycle, by which it is told")
    left_by_cycles = Constant(0.2, "of the variance", "that these leave at most of a force that comes back as it is said to")
    frequency_range = Constant(0.1, "of what is stated", "either way, within which it is looked for", low=0.0, high=0.5)
    frequencies_tried = Constant(400, "1", "either way", source="budget of work")
    phase_apart = Constant(0.25, "cycles", "at the end of a recording, by which force and model have to come apart to be told")
    clearer_frequency = Constant(2.0, "times", "as much has to be left at the frequency that is stated", low=1.0)

    # Jumps
    bend_error = Constant(0.5, "of a bend", "what may be wrong in the samples that make it", high=1.0)
    least_bend_error = Constant(0.2, "of the noise", "an error beside a jump that is less is none")
    largest_bend_error = Constant(
        1e4, "of the noise", "an error beside a jump that is more is no larger; a dead sensor has no noise", source="safety limit"
    )
    curve_samples = Constant(5, "samples", "whose middle bend is that of a curve")
    widest_block = Constant(24, "innovations", "of a block whose errors go together")

    # Outliers
    samples_to_see_an_outlier = Constant(30, "samples", "of a recording, from which on one that stands alone is seen", low=3)
    outlying_sample = Constant(6.0, "robust sd", "from its neighbours, beyond which a single sample stands alone")
    most_outliers = Constant(0.005, "of the samples", "that stand alone by accident; more are a part of what goes on", high=1.0)

    # Whitening and the model discrepancy
    bands = Constant(20, "1", "of the harmonics, and again as many of all between them; those that no record has are left out")
    cycles_of_a_periodic_motion = Constant(1.5, "cycles", "in a recording, from which on harmonics have bands of their own", low=1.0)
    width_of_a_harmonic = Constant(0.75, "lines of the spectrum", "what is further from a harmonic lies between them")
    correlation_samples = Constant((0.3, 2.0, 8.0, 32.0, 128.0), "samples", "over which a discrepancy may be correlated")
    outlying_repeat = Constant(5.0, "robust sd", "of the repeats from each other, beyond which a sample is taken from the others")
    least_discrepancy = Constant(0.002, "of the rms", "from sample to sample: no model of a contact is better, whatever repeats say")
    discrepancy_numbers = Constant(
        2.0, "numbers of a band", "as which the discrepancy in it counts: it is wrong in a few ways, not in each sample"
    )
    aperiodic_share = Constant(0.1, "of the variance", "of the discrepancy of a periodic motion, that may not repeat", high=1.0)
    discrepancy_range = Constant((5e-4, 1.0), "of the rms", "sizes of a discrepancy that are tried, beside 0")
    discrepancy_sizes = Constant(23, "1", "sizes that are tried in that range", low=2)
    usual_discrepancy = Constant(0.02, "of the rms", "a discrepancy of this size is nothing special")

    # Fits
    most_steps = Constant(12, "steps", "of a trust region", source="budget of work")
    smoothly_fitted = Constant(
        3, "models", "of forces that jump, the best, that are fitted by slopes over intervals", source="budget of work"
    )
    first_reach = Constant(3.0, "prior sd", "of each parameter, of the first trust region")
    least_step = Constant(1e-4, "prior sd", "a step that is less is the last one")
    enough_gain = Constant(0.05, "log likelihood", "a step that gains less is the last one")
    linearisations = Constant(3, "1", "of the shapes of the base law, at most", source="budget of work")
    linearisation_step = Constant(0.3, "prior sd", "of the difference by which shapes of the base law are linearised")
    linearisation_range = Constant(1.0, "prior sd", "how far such a linearisation counts")
    least_gain_of_linearising = Constant(
        3.0, "log evidence", "for which shapes of the law are held elsewhere, where a run may take ten times as long"
    )
    fits_from_nominal_values = Constant(
        3, "1", "effects that are fitted from there, where recalibration went far from them", source="budget of work"
    )
    frozen_steps = Constant(5, "steps", "of a first fit of an effect alone, slopes of the nominal parameters held")
    finishing_steps = Constant(4, "steps", "of a fit that begins where that to a part ended")
    evidence_of_form = Constant(
        3.0, "log evidence", "by which a form of the base law has to be better than none: a priori it is no likelier than an effect"
    )
    form_error = Constant(
        0.07, "of the gap", "that recalibration leaves: what no effect explains any closer, since its form in the world is another"
    )
    disbelief = Constant(1.0, "of the value, or of its logarithm", "how far off a nominal value may be if its owner is not believed (sd)")
    evidence_of_disbelief = Constant(
        20.0, "log evidence", "by which other nominal values have to beat every effect before their owner is not believed"
    )

    # Search
    searched_samples = Constant(
        2_500, "samples", "that a look at one value set simulates; repeats of a run cost nothing", source="budget of work"
    )
    worthwhile_part = Constant(0.7, "of all samples", "a part that simulates more saves too little: the whole is searched", high=1.0)
    way_back = Constant(0.5, "of its share of the whole way", "the lesser way that a part of a trial shows, forward or back", high=1.0)
    shown_range = Constant(0.7, "of the largest speed of a trial, or of the range of another input", "that its part shows", high=1.0)
    longer_heads = Constant(3.0, "times the samples", "that are simulated where heads show the motion late", source="budget of work")
    plausible_effect = Constant(0.1, "of the rms", "what an effect does, a priori (sd)")
    first_probe = Constant(1e-4, "of the first guess of an amplitude", "where probing begins")
    probes = Constant(6, "1", "amplitudes that are tried until one does what is plausible", source="budget of work")
    largest_probe_ratio = Constant(100.0, "1", "of one amplitude that is tried to that before", low=1.01)
    near_plausible = Constant(3.0, "1", "so many times more or less than what is plausible is near enough to go by", low=1.01)
    probed_samples = Constant(700, "samples", "of each trial that is probed", source="budget of work")
    probed_conditions = Constant(3, "1", "conditions that are probed")
    probed_means = Constant(8, "means", "that are probed")
    linear_amplitude = Constant(0.3, "prior sd", "of an amplitude, where its slope is taken")
    trial_amplitudes = Constant((0.3, 1.5, 6.0), "prior sd", "the same for an effect with one amplitude, which need not be linear")
    shape_values = Constant(9, "1", "values of a shape that are tried, where an effect has one")
    shape_points = Constant(
        16, "1", "points of a Sobol design that are tried, where it has several", source="budget of work; a power of two"
    )
    shape_range = Constant((1.8, 1.7), "prior sd", "over which those are spread, of one shape and of several")
    starts_of_an_effect = Constant(2, "1", "points of its shapes from which an effect is fitted", source="budget of work")
    starts_apart = Constant(0.8, "prior sd", "in some shape, from which on two such points are worth a fit each")
    trial_times = Constant(9, "1", "amplitudes that are tried where one is a time", source="budget of work")
    shapes_beside_a_time = Constant(
        3, "1", "values of a shape that are tried beside a time, such as dampings, and the more times", source="budget of work", low=2
    )
    straight_range = Constant(2.0, "1", "so many times that where its slope was taken an amplitude may be, and a time as much less")
    periodogram_peaks = Constant(
        12, "1", "of what is left, at which a sine is tried whose frequency or period nobody knows", source="budget of work"
    )
    periodogram_periods = Constant(64, "1", "of a ripple over the position, within the longest way, at most")
    periodogram_lines = Constant(2000, "1", "periods of a line within the longest recording, at most")
    fewest_line_periods = Constant(4, "periods", "of a line within the longest recording: what is slower is a drift, or the motion's own")
    fewest_turns = Constant(
        1, "periods", "of a motion that turns, within the longest recording: a short cut is one turn of a spindle or two"
    )
    least_ripple = Constant(0.5, "periods", "of a ripple over the position, within the longest way")
    phases = Constant(16, "1", "of a sine, that are tried by its quadrature components", low=4)
    refined_points = Constant(
        10,
        "1",
        "points of a design that are looked at with a discrepancy of their own: the best with that of the base",
        source="budget of work",
    )
    least_effect = Constant(1e-5, "of the rms", "a response that is less is not looked for", source="numerical tolerance")
    least_share_of_gain = Constant(
        0.2, "of the best gain", "an effect that gains less where it is taken as linear is not looked at closer", high=1.0
    )
    cost_of_no_effect = Constant(-1.0, "log evidence", "what an effect costs that is not there")
    cost_of_own_value = Constant(
        4.0, "log evidence", "of a phase that a condition or trial has by itself", origin="derived",
        source="half the logarithm of 2 pi times the square that it explains, some hundred times that of the noise",
    )  # fmt: skip
    hopeless_deficit = Constant(12.0, "log evidence", "a model that is this far behind is not looked at closer")
    error_of_linear_gain = Constant(0.85, "of what the best model gains", "as far may a gain by linear sums be off", high=1.0)
    lost_likelihood = Constant(3.0, "log likelihood", "by which a model is behind one that it contains, from which on it starts from there")
    full_fits = Constant(9, "1", "singles that are fitted with all parameters", source="budget of work")
    laws_from = Constant(0.005, "of the rms", "where recalibration leaves less, other base laws are not tried")
    law_starts = Constant(32, "1", "points from which another base law may start", source="budget of work")
    law_start_range = Constant(
        1.5, "prior sd", "over which its own parameters are spread there, where it has some that the nominal law lacks"
    )
    law_steps = Constant(40, "steps", "of the fit of another base law", source="budget of work")
    paired_singles = Constant(4, "1", "singles beside which a second effect is tried", source="budget of work")
    pair_fits = Constant(3, "1", "pairs that are fitted, where there are as many", source="budget of work")
    most_pair_fits = Constant(8, "1", "the same, where linear sums have them as good as the best of those", source="budget of work")
    gain_of_a_pair = Constant(2.0, "log evidence", "over the best single; less may be chance")
    swapped_pairs = Constant(
        2, "1", "pairs that lead, as likely as each other, in which others are tried in place of either effect", source="budget of work"
    )
    swaps = Constant(8, "1", "effects that are tried in place of either of such a pair, where a pair leads", source="budget of work")
    swap_fits = Constant(3, "1", "of those, how many are fitted", source="budget of work")
    singles_fitted_to_all = Constant(5, "1", "of those that were fitted to a part")
    pairs_fitted_to_all = Constant(5, "1", "of those that were fitted to a part, and hardly worse than the best of them")

    # How large the gap is, and whether a fit is to be believed
    noise_floor_error = Constant(0.02, "of the noise floor", "no structural square is known better: on held-out conditions, less is none")
    fewest_conditions = Constant(3, "conditions", "below which none can be held out", low=2)
    folds = Constant(3, "1", "of the conditions, each of which is left out of the fits in turn", low=2)
    same_level = Constant(0.01, "of a factor's range", "settings that differ by less are one level of it")
    fewest_recordings = Constant(3, "recordings", "below which a share of what was fitted has no interval", low=2)
    bootstrap_draws = Constant(1000, "1", "of the interval of the closed share")
    bootstrap_seed = Constant(20240229, "1", "of these draws")
    worse_condition = Constant(1.1, "of the rms without the effect", "from which a held-out condition is made worse", low=1.0)
    surprising = Constant(3.0, "sd", "of noise and of the parameters' spread: by which a true model may make a held-out condition worse")
    foreseen_condition = Constant(
        0.25, "of the mean square that is left", "the variance of a prediction, from which on a held-out condition tests nothing"
    )
    held_out_models = Constant(2, "1", "of the likeliest, that are tried on held-out conditions")
    held_out_rounds = Constant(8, "1", "how often others follow: none is named that was not tried", source="safety limit")
    taken_back = Constant(
        1.0, "of the gap", "that an effect with its values may add, set-up put right, if the form of the law beside them takes it back"
    )
    visible_structure = Constant(3.0, "sd", "of a structural square by noise alone: a gap on held-out conditions that is less is none")
    clear_evidence = Constant(
        10.0, "log evidence", "an effect that gains more is there, however its amplitude and other parameters stand for each other"
    )
    significant_amplitude = Constant(2.0, "sd", "an amplitude that is less from nothing is no better known than its size")
    shortest_lasting = Constant(0.05, "of the way", "on which what changes for good does so: a shorter one would begin anew each time")
    near_bound = Constant(
        0.1, "prior sd", "a parameter at its bound that is known as well, and would go no further without it, is credible"
    )
    distance_to_bound = Constant(1e-3, "prior sd", "a parameter that is nearer lies at its bound", source="numerical tolerance")
    advised_share = Constant(
        0.5, "of the gap", "that an effect must close where no fit has looked, or the corrected model is not advised", high=1.0
    )
    notable_remainder = Constant(2.0, "noise floors", "what recalibration leaves is told from here on")
    notable_second = Constant(0.1, "probability", "an effect that may act beside what is named is told from here on")
    absurd_effect = Constant(3.0, "of the rms", "no effect does so much, unless something else takes it back", source="safety limit")
    credible_shift = Constant(3.5, "prior sd", "a nominal value that moves further was not credible: one in 2000 is off by so much")
    credible_shift_slope = Constant(
        2.0, "log-odds per prior sd", "by which a shift beyond that is no mis-tuning, where an effect needs none"
    )
    stated_freedom = Constant(
        16.0,
        "degrees of freedom",
        "of Student's t, by whose tails a stated value counts against models that move it: of an uncertainty that is itself known to 18 %",
        source="Guide to the expression of uncertainty in measurement (2008), G.4.2",
    )
    accuracy_of_laws = Constant(
        0.02, "of the rms", "no friction law follows a measured force any closer: a gap of this size is nothing to look at"
    )

    # Judgement: the weights that `evat calibrate` fits
    temperature = Constant(20.0, "log evidence", "of the evidence", origin="calibrated")
    sharpness = Constant(6.0, "log-odds", "per factor e^-2 in the share of the gap that is left", origin="calibrated")
    form = Constant(0.05, "of the gap", "that may be left by an effect of a slightly other form", origin="calibrated")
    effect_cost = Constant(4.0, "log-odds", "of each further effect", origin="calibrated")
    cost_of_generality = Constant(
        1.1,
        "log-odds",
        "of an effect beside a special case of it: three to one for that, where what the effect has besides is out of sight",
    )
    gap_offset = Constant(0.0, "log-odds", "of a nominal gap that is as large as what nobody would look at", origin="calibrated")
    gap_slope = Constant(2.0, "log-odds", "per e-fold of the nominal gap over what nobody would look at", origin="calibrated")
    structure_offset = Constant(0.0, "log-odds", "gap_offset, of what recalibration leaves", origin="calibrated")
    structure_slope = Constant(2.0, "log-odds", "gap_slope, of what recalibration leaves", origin="calibrated")
    unknown_offset = Constant(-0.5, "log-odds", "of unknown where the best model leaves half", origin="calibrated")
    unknown_slope = Constant(3.0, "log-odds", "per log-odds of the share that the best model leaves", origin="calibrated")
    evident = Constant(
        15.0, "log evidence", "that makes an effect as likely as not where the gap itself is too small to look at", origin="calibrated"
    )
    small_noise = Constant(0.5, "of the noise's rms", "a structural gap of this size is nothing to look at", origin="calibrated")
    small_form = Constant(0.01, "of the rms", "a structural gap of this size is nothing to look at", origin="calibrated")
    irregular = Constant(
        0.3, "of what repeats do not share", "bursts and lines that make something foreign as likely as not", origin="calibrated"
    )

    # What is told of recalibration
    noticeable_rise = Constant(1.005, "times the rms of the nominal values", "less nobody sees")

    # What is certain and small
    certain_evidence = Constant(20.0, "log evidence", "over none: beyond what the form of a law, or a set-up, has been seen to feign")
    rival_deficit = Constant(5.0, "log evidence", "a rival that is less behind may be it as well")
    small_share = Constant(0.01, "of the rms of a channel", "more is no small effect")

    # Judgement: the others
    second_effect_share = Constant(0.3, "of what the first leaves", "a second effect that takes less adds less evidence in proportion")
    likely_probability = Constant(0.9, "1", "what the listed sets hold", high=0.999)
    chance_evidence = Constant(5.0, "log evidence", "less is chance")
    chance_evidence_scale = Constant(2.0, "log evidence", "over how much more that becomes certain")
    least_gap_size = Constant(0.2, "of what nobody would look at", "a structural rms below that is no smaller")
    glimpsed_gap_size = Constant(
        0.3, "of what nobody would look at", "of a larger structural rms, what an effect leaves of it says something"
    )
    few_numbers = Constant(150.0, "1", "measured numbers, of which evidence overstates half as much as of many")
    evidence_of_other_forms = Constant(
        2.0,
        "times",
        "the evidence that simulated cases ask of an effect: in a world whose laws are others than the library's, forms feign more",
    )
    score_of_other_forms = Constant(
        0.8,
        "times",
        "what simulated cases make of a difference of scores: in a world whose laws are others than the library's, it decides less",
        source="kept cases of a world that others made, seeds 2281 to 2333, and six worlds more: 209 cases",
    )
    gap_elsewhere = Constant(
        1.5,
        "log-odds",
        "of a gap by its size, beyond what simulated cases make of it: a small one hides more than theirs do",
        source="the same cases: of 51 in which a gap was said to have a probability of 0.06, 12 had one",
    )
    unknown_elsewhere = Constant(
        0.25,
        "log-odds",
        "of something unknown beyond what simulated cases make of it: theirs are effects of the library that was taken out of it",
        source="the same cases",
    )
    evidence_for_what_is_left = Constant(4.5, "1", "times more evidence is asked of an effect that leaves all of what can be seen")
    worse_gap = Constant(
        1.03, "of the gap that recalibration leaves", "a model that leaves more makes it worse, whatever its evidence", low=1.0
    )
    chance_structure = Constant(2.0, "sd", "of a structural square by noise alone: so much few numbers may leave")
    unseen_share = Constant(0.2, "1", "that a model with much evidence is held to leave of a gap that is too small to look at", high=1.0)
    irregularity_slope = Constant(20.0, "log-odds", "per share of irregularity: noise has next to none")
    least_named_probability = Constant(0.55, "of what the library knows to act", "a set with less is one of several", high=0.999)
    least_effect_probability = Constant(
        0.65,
        "of what the library knows to act",
        "an effect with more in all its sets together is named, whatever may act beside it",
        high=0.999,
    )
    calibration_prior_sd = Constant(
        0.14, "1, or of the logarithm", "of each fitted weight about its start: simulated cases are not real ones"
    )
    least_calibrated_probability = Constant(1e-3, "1", "below which a case counts no worse in the calibration", high=1.0)

    # What is told
    least_candidate = Constant(1e-4, "1", "probability below which a set is no candidate", high=1.0)
    notable_irregularity = Constant(0.1, "of what repeats do not share", "bursts and lines that are told of")
    least_described_share = Constant(0.05, "of the gap", "channels with less are not described")
    region_share = Constant(0.8, "of the square", "what a region is to hold", high=0.999)
    region_concentration = Constant(0.08, "of all samples", "a region has at least so many fewer than what it holds of the square")
    region_part = Constant(0.15, "of the square", "what each of two ranges must hold at least", high=0.5)
    region_simplicity = Constant(
        0.75, "of the samples of one range", "two ranges or two quantities take fewer, or one range is told", high=1.0
    )
    region_bins = Constant(40, "1", "of a quantity alone")
    region_bins_of_two = Constant(16, "1", "of each of two quantities")
    region_rounding = Constant(
        1e-9, "of the square", "a share that is as much less is as much", origin="derived", source="rounding of sums"
    )
    next_experiment_factors = Constant((0.25, 0.5, 2.0, 4.0), "of what has been measured", "inputs as a whole, or a value of the condition")
    next_experiment_samples = Constant(1500, "samples", "of a trial that an advised experiment is simulated for", source="budget of work")
    next_experiment_conditions = Constant(4, "conditions", "that an advised experiment may start from", source="budget of work")
    next_experiment_hypotheses = Constant(
        4, "hypotheses", "likely ones, that an advised experiment is to tell apart", source="budget of work"
    )
    averaged_samples = Constant(10, "samples", "over which noise averages out where two models differ for long, in an advised experiment")
    least_form_in_advice = Constant(0.01, "of the rms", "by which models of this kind are wrong at least, where an experiment is advised")
    detected_amplitude = Constant(3.0, "sd", "an amplitude that would show")
    fmu_samples = Constant(60_000, "samples", "that the corrected FMU is run for at most, some 2 s of them", source="budget of work")


CONSTANTS = _Constants()

# Of the constants that say how other worlds differ: the world of simulated cases is the library's own.
OWN_WORLD: Mapping[str, Value] = MappingProxyType(
    {"evidence_of_other_forms": 1.0, "score_of_other_forms": 1.0, "gap_elsewhere": 0.0, "unknown_elsewhere": 0.0}
)
