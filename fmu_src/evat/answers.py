"""What does one ask of an experiment, or of the folder of one? `diagnose` and `identify`; the contact is the model where none is named.

The rooms behind them know a model by the words of evat.model alone; here it is known which model this package is about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from evat.experiment import Experiment
from evat.identification.settings import Execution, Settings
from evat.model import Model, ParameterError, nearest
from evat.units import to_si

if TYPE_CHECKING:
    from evat.gap import Report
    from evat.gap.answer import Diagnosis
    from evat.identification.result import Identification

Asked = Experiment | str | PathLike[str]
DEFAULT, HERE = Settings(), Execution()


def diagnose(
    experiment: Asked, model: Model | None = None, *, version: str = "", report: Report | None = None, whole: bool = False
) -> Diagnosis:
    """Say where measurement and nominal model disagree, which effect causes it, and how far the gap shrinks with it.

    Parameters
    ----------
    experiment : Experiment or path
        Recorded trials, means, or both, with the nominal model; or the folder of an experiment, which is read. Trials of more than a
        million rows are compressed (`compress_experiment`), and the answer says how.
    model : Model, optional
        What simulates it, with the effects that it offers; without it a `ContactModel`.
    version : str
        Of the caller, kept in the answer.
    report : callable, optional
        Told what is being done and the share that is done.
    whole : bool
        Look at all samples of a record, however long that takes; without it at the first thousands, and the rest is only compared.

    Returns
    -------
    Diagnosis
        `verdict` is no_gap, mistuned, effect, ambiguous, unknown or cannot_tell; `effects` are those named, with their probability
        and parameters; `json()` is all of it.

    Raises
    ------
    ExperimentError
        Where nothing can be compared.
    SimulationError
        Where the nominal model does not run.

    Examples
    --------
    A contact that holds better one way than the other, and a nominal model that knows nothing of it:

    >>> import evat
    >>> from dataclasses import replace
    >>> truth = {"friction_law": "coulomb", "F_C": 8.0}
    >>> made = evat.orthogonal(truth, ["direction_asymmetry"], motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=50.0)
    >>> made = replace(made, nominal=replace(made.nominal, effects=()))
    >>> model = evat.ContactModel()
    >>> model.effects = tuple(each for each in model.effects if each.name in ("direction_asymmetry", "dwell_strengthening"))
    >>> answer = evat.diagnose(made, model)
    >>> answer.verdict, [effect.name for effect in answer.effects]
    ('effect', ['direction_asymmetry'])
    """
    from evat.gap import diagnose as of_model

    asked, simulated, told = _asked(experiment, model)
    answer = of_model(asked, simulated, version=version, report=report, whole=whole)
    return replace(answer, cannot_tell=(*answer.cannot_tell, *told))


def identify(
    experiment: Asked,
    model: Model | None = None,
    free: Sequence[str] = (),
    settings: Settings = DEFAULT,
    *,
    execution: Execution = HERE,
) -> Identification:
    """Find the free parameters of a model from an experiment, and what the experiment says about each.

    Parameters
    ----------
    experiment : Experiment or path
        Recorded trials, means, or both, with the nominal model; or the folder of an experiment, which is read. Trials of more than a
        million rows are compressed (`compress_experiment`), and the answer says how.
    model : Model, optional
        What simulates it; without it a `ContactModel`.
    free : sequence of str, optional
        Names of the parameters to find; without them those of which the experiment says how well they are known (nominal.relative_sd).
    settings : Settings
        What decides the answer beside these: effects and values that are held, bounds, objective, search, what is kept out of the fit.
    execution : Execution
        How the work is carried out: journal, threads or a cluster, progress, cancelling.

    Returns
    -------
    Identification
        `result[name]` has value, sd, the 90 % interval from low to high, and a verdict: identified, weak, not identifiable, or withheld
        where the interval cannot be believed.

    Raises
    ------
    ParameterError
        For names and bounds that are not allowed.
    ExperimentError
        For what would be a nonsense fit: a clock that jumps, signs, a force of zero.
    EvatError
        Where the search to go on with is another one.

    Notes
    -----
    The paper, section 4.2, searches with a genetic algorithm and eq. 9; the intervals are made in `evat.identification.profile`.

    Examples
    --------
    >>> import evat
    >>> truth = {"friction_law": "coulomb", "F_C": 8.0}
    >>> made = evat.orthogonal(truth, motion="reversal", repeats=2, speeds=[0.1, 0.5], rate=100.0, seed=1)
    >>> result = evat.identify(made, free=["F_C"], settings=evat.Settings(search="none"))
    >>> print(f"{result['F_C'].value:.2f} N, {result['F_C'].verdict}")
    8.00 N, identified
    >>> print(result.summary())  # doctest: +ELLIPSIS
    [[Fit]]
        experiment              = Orthogonal cutting tests, simulated: reversal
    ...
    """
    from evat.identification.run import identify as of_model

    asked, simulated, told = _asked(experiment, model)
    wanted = (free,) if isinstance(free, str) else tuple(free)
    answer = of_model(asked, simulated, wanted or _uncertain(asked), _in_si(settings, simulated), execution=execution)
    return replace(answer, doubts=(*answer.doubts, *told))


def _asked(experiment: Asked, model: Model | None) -> tuple[Experiment, Model, tuple[str, ...]]:
    """The experiment, the model, and what was done with trials that are too long."""
    if model is None:
        from evat.models.contact import ContactModel

        model = ContactModel()
    elif not hasattr(model, "simulate_many"):
        raise ParameterError(f"model = {model!r}: this is no model; names of parameters go by keyword, for example free=['F_C'].")
    if isinstance(experiment, Experiment):
        return experiment, model, ()
    from evat.experiment.compression import read_or_compress

    read, told = read_or_compress(Path(experiment), model)
    return read, model, told


def _uncertain(experiment: Experiment) -> tuple[str, ...]:
    """What the owner of the experiment does not know exactly."""
    names = tuple(name for name, sd in experiment.nominal.relative_sd.items() if sd > 0)
    if not names:
        raise ParameterError(
            "free is empty, and the experiment says of no parameter how well it is known (nominal.relative_sd); name those to find, for "
            "example free=['F_C']."
        )
    return names


def _in_si(settings: Settings, model: Model) -> Settings:
    """Settings whose texts with units have become numbers."""
    variables = {variable.name: variable for variable in model.variables}

    def number(name: str, given: float | str) -> float | str:
        if not isinstance(given, str):
            return given
        if name not in variables:
            raise ParameterError(f"there is no variable {name!r}; {nearest(name, variables)}")
        return given if variables[name].type == "choice" else to_si(given, variables[name].unit, name=name)

    bounds = {name: (number(name, low), number(name, high)) for name, (low, high) in settings.bounds.items()}
    return replace(settings, values={name: number(name, given) for name, given in settings.values.items()}, bounds=bounds)  # type: ignore[arg-type]
