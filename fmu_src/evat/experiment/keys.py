"""Which keys does an experiment.toml have? The one declaration: the reader checks by it, `evat experiment init` comments by
it, the guide prints it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Key:
    """One key of a table: what is written there, what counts where it is missing ("" where nothing does), and what it says."""

    name: str
    takes: str
    default: str
    meaning: str
    needed: bool = False


# Each table by how it is headed; "" is the top of the file.
TABLES: dict[str, tuple[Key, ...]] = {
    "": (
        Key("format", "1", "", "version of this format", needed=True),
        Key("title", "text", "", "what was measured; heads every report", needed=True),
        Key("intended_use", "text", "", "what the model is for; printed in the report"),
        Key("reader", "table", "", "how the text files are written"),
        Key("nominal", "table", "", "the model as you believe it today", needed=True),
        Key("signals", "tables", "", "one for each measured quantity, by the component's variable name"),
        Key("setup_sd", "tables", "", "how far a channel may be off in all trials alike, by its name"),
        Key("trials", "[[trials]]", "", "one for each recording"),
        Key("means", "table", "", "a file of averages, a row for each condition"),
    ),
    "[reader]": (
        Key(
            "delimiter",
            "one character",
            "the commonest of tab, semicolon, comma in the header line",
            "stands between two columns; a blank: any number of them",
        ),
        Key("decimal", '"." or ","', '"."', "decimal mark of the numbers"),
        Key("encoding", "text", '"utf-8"', 'of the headers, such as "cp1252"'),
        Key("skip_rows", "whole number", "0", "lines above the line of headers"),
        Key(
            "rows_after_header",
            "whole number",
            "0",
            "lines between the headers and the first numbers; one of units must agree with the signals",
        ),
        Key(
            "columns",
            "list of headers",
            "",
            "of files without a line of them, in the order of their columns: files that begin with numbers in their first line or after "
            "skip_rows; any other goes by its own",
        ),
        Key("timestamp", "header", "", "column of the clock where it is written as times of day, hh:mm:ss; it counts from its first row"),
    ),
    "[nominal]": (
        Key("friction", "a friction law", "that of parameters", "the law by which the contact rubs"),
        Key("kinematics", "external or internal", "that of parameters", "external: the slip velocity is a signal; internal: the path runs"),
        Key("parameters", "text", "", "a shipped set, or a path to an .ssv file beside this one"),
        Key("effects", "list of names", "those of parameters", "effects that are in the nominal model already"),
        Key("values", "table of numbers", "", "SI, by the component's names; they come over parameters"),
        Key(
            "relative_sd",
            "table of numbers",
            "0.1 each, 0.01 of temperatures",
            "how well each value is known, as a share of it; 0 is exact",
        ),
        Key("sd", "table of numbers", "", "the same as standard deviations, in the SI units of the values; each in one of both tables"),
        Key("proxy_source", "a choice", "slip_speed", "what heats the contact; a recorded temperature counts where it is named"),
        Key("initial_bristle", "free, relaxed or slid_in", "free", "how bristles are bent when a trial begins"),
        Key("mass", "number, kg", "0", "moves with the slip; mass times acceleration is taken off the friction force"),
        Key("gravity_load", "number, N", "0", "constant load that is taken off the friction force"),
    ),
    "[signals.NAME]": (
        Key("column", "text", "NAME", "header of the column in every data file"),
        Key("unit", "text", "", "of the column, such as mm/s; converted to SI; a trigger needs none", needed=True),
        Key("role", "input or output", "", "whether it drives the model or is to be predicted; the clock and the trigger have none"),
        Key("full_scale", "number", "", "the sensor's range, in the unit; of outputs"),
        Key("sign", "1 or -1", "1", "-1 where the sensor counts the other way"),
        Key("scale", "number", "", "times the value in the SI unit of the column, such as 5.2 N/A of a motor's current"),
        Key("offset", "number", "0", "added after sign and scale, in the variable's SI unit; neither turns it"),
        Key("from", "position", "", "the column is a position, and is differentiated"),
        Key("radius", "number, m", "", "lever arm of a column that is an angle, an angular velocity or a torque; in place of a scale"),
    ),
    "[setup_sd.NAME]": (
        Key("gain", "number", "0.01", "standard deviation of its gain; 0 is exact"),
        Key("zero", "number", "0.01 of its root mean square", "of its zero, in the unit of the column, times scale as that is"),
        Key("clock", "number", "one sample", "of its lag, in the unit of the time; identify tells what it may move, and takes it for 0"),
        Key(
            "clock_drift",
            "number",
            "0.0002",
            "of the rate at which that lag grows beside a recorded motion or what drives a vibration; of a diagnosis alone",
        ),
    ),
    "[[trials]]": (
        Key("file", "path", "", "inside the folder, written with /", needed=True),
        Key("condition", "text", "", "trials of one condition are repeats of each other", needed=True),
        Key(
            "rows",
            "table of numbers, by header",
            "all",
            "only the rows in which these columns of the file have these values: a counter of runs",
        ),
        Key("values", "table of numbers", "", "SI, exact: what it was run at; sliding_distance: how far the contact had slid before"),
        Key("noise_sd", "table of numbers", "that of repeats", "SI, by output: standard deviation of a sample's noise, where it is known"),
    ),
    "[means]": (
        Key("file", "path", "", "inside the folder; its columns are signals, or headed by names of variables", needed=True),
        Key("ignore", "list of headers", "", "columns that are no values and no means, such as remarks"),
    ),
}


def keys(table: str) -> tuple[str, ...]:
    """The names of a table's keys."""
    return tuple(key.name for key in TABLES[table])


def needed(table: str) -> tuple[str, ...]:
    """Those without which it says nothing."""
    return tuple(key.name for key in TABLES[table] if key.needed)


def meaning(table: str, name: str) -> str:
    """What a key says, for a comment beside it."""
    return next(key.meaning for key in TABLES[table] if key.name == name)
