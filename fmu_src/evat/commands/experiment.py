"""`evat experiment`: is a folder of measurements fit to be used, and what would tests of a known contact measure?"""

from __future__ import annotations

import dataclasses
import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from evat import parameter_sets
from evat.commands.begin import check_page, init, write_page
from evat.commands.recovery import recovery
from evat.commands.shared import Json, SpeedUnit, Values, grouped, only, print_json, share_done, typed_values
from evat.commands.tables import WholeTable
from evat.console import err, marked, out
from evat.model import ParameterError
from evat.motions import KINDS
from evat.native import kernel
from evat.required_inputs import unread_inputs, unused_by_law
from evat.studies.examples import EXAMPLES
from evat.units import to_si

if TYPE_CHECKING:
    from evat.experiment.document import Document

experiment = typer.Typer(
    name="experiment",
    no_args_is_help=True,
    help="Measured experiments: begin with a folder of data files, check one, or simulate tests of a contact whose parameters are known.",
)
experiment.command()(init)
experiment.command()(recovery)
LONGEST_NAME = 24  # characters of a line that the name of a file may take from what stands beside it
Folder = Annotated[Path, typer.Argument(help="A folder with an experiment.toml, or such a file.")]


@experiment.command()
def check(
    folder: Folder,
    to: Annotated[Path | None, typer.Option("--out", "-o", help="Write it as a page, too: an .html file.")] = None,
    as_json: Json = False,
) -> None:
    """Read an experiment of any size, check every number, and list its trials and averages; or say what is wrong with it.

    Example: evat experiment check tests/copper
    """
    from evat.experiment.read import scan_experiment
    from evat.experiment.skips import skipped
    from evat.inference.checks import check_crowd, check_gap, check_rows
    from evat.models.contact import ContactModel
    from evat.plots.experiment_page import channels_of, conditions_told, large_zeros, means_of, setup_known, trials_of, values_known

    check_page(to)
    with share_done(f"checking {folder.name}") as progress:
        scan = scan_experiment(folder, ContactModel(), progress=progress)
    for trial in scan.trials:
        check_rows(trial.file, trial.rows)
        check_gap(trial.file, trial.longest, trial.usual, trial.longest_after, trial.longest_from)
        check_crowd(trial.file, trial.shortest, trial.usual, trial.shortest_after)
    document, means = scan.document, scan.means
    if as_json:
        print_json(
            {
                "title": document.title,
                "signals": {name: {"column": each.column, "unit": each.unit, "role": each.role} for name, each in document.signals.items()},
                "trials": [dataclasses.asdict(trial) for trial in scan.trials],
                "averages": [] if means is None else list(means.conditions),
                "nominal": {"values": document.nominal.values, "effects": document.nominal.effects},
                "data": scan.data_hash,
            }
        )
    tables = [trials_of(scan), dataclasses.replace(channels_of(scan), title="")] if scan.trials else []
    for each in (*tables, means_of(scan)):
        if each is not None:
            table = WholeTable(title=each.title or None, title_justify="left")
            for place, head in enumerate(each.heads):  # what tells rows apart is read in one line, as far as that goes
                table.add_column(head, no_wrap=not place and max(len(row[0]) for row in each.rows) <= LONGEST_NAME)
            for row in each.rows:
                table.add_row(*row)
            out.print(table)
    rows = sum(trial.rows for trial in scan.trials)
    averages = [f"{len(means.conditions)} rows of averages"] if means is not None else []
    recordings = [f"{len(scan.trials)} trials of {rows} rows in all"] if scan.trials else []
    out.print(f"{', '.join([*recordings, *averages])}; {conditions_told(scan)}")
    out.print(_nominal(document))
    for known in (values_known(document), setup_known(scan)):
        if known:
            out.print(known)
    recorded = {name for name, signal in document.signals.items() if signal.role == "input"}
    stated = {name for trial in document.trials for name in trial.values} | set(() if means is None else means.values)
    nominal, model = document.nominal, ContactModel()
    unread = unread_inputs(model, nominal.values, recorded, stated)
    unused = unused_by_law(model, kernel.laws(), nominal.values, nominal.effects, recorded)
    doubts = [*unread, *unused, *skipped(scan), *large_zeros(scan), *(remark.text for remark in scan.remarks)]
    for doubt in doubts:
        err.print(marked("warning:", "bold yellow", doubt), soft_wrap=True)
    out.print(f"data {scan.data_hash}", highlight=False, soft_wrap=True)
    if to is not None:
        out.print(f"wrote {write_page(scan, to, doubts)}", soft_wrap=True)


@experiment.command()
def compress(
    folder: Folder,
    to: Annotated[Path, typer.Option("--out", "-o", help="A new folder for what the records tell.")],
    samples: Annotated[
        int | None,
        typer.Option(help="Samples to keep of all trials, repeats counted once; without it as many as a diagnosis simulates.", min=1),
    ] = None,
    suffix: Annotated[str, typer.Option(help="Of the data files: .csv or .parquet.")] = ".parquet",
    as_json: Json = False,
) -> None:
    """Compress long recordings to what they tell: an experiment as any other, of the whole record.

    Stretches that repeat themselves become average cycles, spread over the record, in two halves that tell their noise; what is held
    becomes averages; what passes is kept. Each knows its time and how far the contact had slid. identify and diagnose do it by themselves
    with trials of more than a million rows.

    Example: evat experiment compress ten-minutes -o ten-minutes-short
    """
    from evat.experiment.compression import compress_experiment
    from evat.experiment.write import check_new, write_experiment
    from evat.models.contact import ContactModel

    check_new(to)
    with share_done(f"compressing {folder.name}") as progress:
        compressed = compress_experiment(folder, ContactModel(), samples=samples, progress=progress)
    made = write_experiment(compressed.experiment, to, suffix=suffix)
    if as_json:
        print_json([dataclasses.asdict(told) for told in compressed.told])
    for told in compressed.told:
        out.print(str(told), highlight=False)
    out.print(f"wrote {made}: {len(compressed.experiment.trials)} trials of {compressed.experiment.samples} samples in all", soft_wrap=True)
    out.print(f"next: evat diagnose {made}", soft_wrap=True)


def _nominal(document: Document) -> str:
    from evat.plots.experiment_page import shown

    nominal, signals = document.nominal, document.signals
    values = ", ".join(
        f"{name} = {value if isinstance(value, str) else shown(value, name, signals)}" for name, value in nominal.values.items()
    )
    source = f" (with the set {nominal.parameters})" if nominal.parameters else ""
    moves = document.inertia
    taken = "" if moves is None else f"; off the friction force goes what moves: {moves.mass:g} kg, {moves.load:g} N of load"
    bent = {"free": "free, bent anyhow", "relaxed": "relaxed", "slid_in": "slid in, bent by what came before"}[nominal.initial_bristle]
    begin = f"; bristles begin {bent}" if document.trials else ""
    effects = ", ".join(nominal.effects) or "none"
    return f"nominal model{source}: {values}; effects on: {effects}{taken}{begin}; all else as the component starts"


@dataclasses.dataclass(frozen=True)
class TestOptions:
    """What is tested, and how it is recorded."""

    motion: Annotated[str, typer.Option(help=f"How the contact is moved: {', '.join(KINDS)}.")] = "ramp"
    repeats: Annotated[int, typer.Option(help="Trials of each condition.")] = 3
    noise: Annotated[str, typer.Option(help="Standard deviation over the force's root mean square.")] = "1 %"
    seed: Annotated[int, typer.Option(help="Of the noise and of the nominal values.", min=0)] = 0
    rate: Annotated[str, typer.Option(help="Sampling rate.")] = "1 kHz"
    speed: Annotated[list[str] | None, typer.Option(help="A test speed, such as '20 m/min'; repeat it. Without it five are chosen.")] = None
    proxy: Annotated[str, typer.Option(help="What the heated motions heat by: contact_temperature or proxy_speed.")] = "contact_temperature"
    output: Annotated[list[str] | None, typer.Option(help="What is measured; repeat it. Without it friction_force.")] = None


@dataclasses.dataclass(frozen=True)
class NominalOptions:
    """What the nominal model has of the truth."""

    nominal_off: Annotated[str, typer.Option(help="How far the nominal model's coefficients are off at most.")] = "30 %"
    truth_in_nominal: Annotated[bool, typer.Option("--truth-in-nominal", help="The nominal model is the truth.")] = False


@experiment.command()
@grouped
def orthogonal(
    *,
    context: typer.Context,
    to: Annotated[Path, typer.Option("--out", "-o", help="A new folder for the experiment.")],
    parameters: Annotated[str | None, typer.Option("--set", "-s", help="The truth: a shipped set or an .ssv file.")] = None,
    value: Values = None,
    effect: Annotated[
        list[str] | None, typer.Option("--effect", "-e", help="An effect that is on beside those of the set; repeat it.")
    ] = None,
    tests: TestOptions,
    nominal: NominalOptions,
    truth: Annotated[Path | None, typer.Option(help="Write the truth to this .ssv file, outside the folder.")] = None,
    speed_unit: SpeedUnit = "m/min",
    suffix: Annotated[str, typer.Option(help="Of the data files: .csv or .parquet.")] = ".csv",
) -> None:
    """Simulate tests of a contact whose parameters are known; write an experiment with noise, and a picture of it.

    The folder does not tell the truth: its nominal values are off, and --truth writes the true ones elsewhere.

    Example: evat experiment orthogonal -s published/copper --noise '1 %' --seed 1 --out copper --truth copper.ssv
    """
    from evat.experiment.write import check_new, write_experiment
    from evat.plots.experiment import plot_experiment
    from evat.studies.orthogonal import orthogonal as simulated
    from evat.studies.orthogonal import truth_of

    if truth is not None and (truth.suffix != ".ssv" or Path(os.path.abspath(truth)).is_relative_to(os.path.abspath(to))):
        raise ParameterError(f"--truth {truth}: an .ssv file outside {to} is needed, so that the experiment does not tell.")
    only(context, parameters is not None, "with --set", "speed_unit")
    check_new(to)
    parameter_set = (
        parameter_sets.load(parameters, speed_unit=speed_unit)
        if parameters is not None
        else parameter_sets.ParameterSet("values", "values", {})
    )
    values = {**parameter_set.by_choice, **typed_values(value, {name: f"--effect {name}" for name in effect or ()})}
    effects = (*parameter_set.effects, *(name for name in effect or () if name not in parameter_set.effects))
    made = simulated(
        values,
        effects,
        motion=tests.motion,
        repeats=tests.repeats,
        noise=to_si(tests.noise, "1", name="noise"),
        seed=tests.seed,
        rate=to_si(tests.rate, "Hz", name="rate"),
        speeds=[to_si(each, "m/s", name="speed") for each in tests.speed] if tests.speed else None,
        proxy=tests.proxy,
        outputs=tuple(tests.output or ("friction_force",)),
        nominal_off=0.0 if nominal.truth_in_nominal else to_si(nominal.nominal_off, "1", name="nominal_off"),
    )
    out.print(f"wrote {write_experiment(made, to, suffix=suffix)}: {len(made.trials)} trials, {len(made.conditions)} conditions")
    out.print(f"wrote {plot_experiment(made, to / 'experiment.png')}")
    if truth is not None:
        whole = {name: number for name, number in kernel.check_values(truth_of(values, tests.motion, tests.proxy)).items()}
        notes = (f"truth of simulated tests: {tests.motion}, seed {tests.seed}",)
        kept = parameter_sets.ParameterSet(
            parameter_set.name, parameter_set.title, whole, effects, parameter_set.sources, notes, parameter_set.speed_range
        )
        out.print(f"wrote {parameter_sets.save_ssv(kept, truth)}")


@experiment.command()
def example(
    name: Annotated[str, typer.Argument(help=f"Which one: {', '.join(EXAMPLES)}.")],
    to: Annotated[Path, typer.Option("--out", "-o", help="A new folder for the experiment.")],
    seed: Annotated[int, typer.Option(help="Of the noise; the same seed gives the same files.", min=0)] = 0,
) -> None:
    """Write a small simulated experiment to try things on, and a picture of it.

    rig: strokes of a friction rig; cut: forces of elliptical vibration cutting; averages: mean forces over cutting speed; axis: a motor's
    angle and current.

    Example: evat experiment example axis -o my-axis
    """
    from evat.experiment.read import read_experiment
    from evat.experiment.write import check_new
    from evat.models.contact import ContactModel
    from evat.plots.experiment import plot_experiment
    from evat.studies.examples import write_example

    check_new(to)
    out.print(f"wrote {write_example(name, to, seed)}")
    made = read_experiment(to, ContactModel())
    if made.trials:
        out.print(f"wrote {plot_experiment(made, to / 'experiment.png')}")
    out.print(f"next: evat experiment check {to}", soft_wrap=True)


@experiment.command()
def advise(
    context: typer.Context,
    parameters: Annotated[
        str | None, typer.Option("--set", "-s", help="What is believed of the contact: a shipped set or an .ssv file.")
    ] = None,
    value: Values = None,
    speed_unit: SpeedUnit = "m/min",
    as_json: Json = False,
) -> None:
    """Say what to record, how long, how fast sampled and how often, so that the parameters of a contact show.

    Scaled by F_C, F_S, sigma0 and v_s, as far as you believe to know them.

    Example: evat experiment advise -v 'F_C=12 N' -v 'sigma0=0.5 N/um' -v 'v_s=5 mm/s'
    """
    from evat.studies.recording import recordings

    only(context, parameters is not None, "with --set", "speed_unit")
    believed = {} if parameters is None else dict(parameter_sets.load(parameters, speed_unit=speed_unit).values)
    table = WholeTable("motion", "conditions", "each at least", "sampled at", "repeats", title="What to record", title_justify="left")
    advised = recordings({**believed, **typed_values(value)})
    if as_json:
        print_json([dataclasses.asdict(each) for each in advised])
    for each in advised:
        conditions = ", ".join(_millimetres(number, "/s" * bool(each.speeds)) for number in each.speeds or each.strokes)
        table.add_row(each.motion, conditions, f"{each.seconds:.3g} s", f"{each.rate:.0f} Hz", str(each.repeats))
    out.print(table)
    for each in advised:
        out.print(f"{each.motion} (for {', '.join(each.shows)}): {each.why}.")
    out.print(
        "Record time, velocity (or position) and force with one clock, the normal load beside them, unfiltered; begin and end each "
        "recording at rest; keep temperature and lubrication; give repeats the same name with _rep1, _rep2.\n"
        "next: evat experiment init FOLDER"
    )


def _millimetres(number: float, per: str) -> str:
    return f"{1e3 * number:.3g} mm{per}" if number >= 1e-4 else f"{1e6 * number:.3g} um{per}"
