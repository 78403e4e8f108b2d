"""What does a large recording cost to read? Writes one, or reads one in a process of its own and tells time and peak memory as JSON.

python large_record.py write FOLDER MEGABYTES SUFFIX | scan FOLDER | read FOLDER | diagnose FOLDER
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet
from evat.constants import CONSTANTS
from evat.experiment.read import read_experiment, scan_experiment
from evat.gap import diagnose
from evat.models.contact import ContactModel
from peak_memory import peak

ROWS = 1 << 18  # written at a time
DOCUMENT = """format = 1
title = "A long recording"
[nominal]
friction = "lugre"
kinematics = "external"
parameters = "lugre-1995"
[signals.time]
column = "t [s]"
unit = "s"
[signals.slip_velocity]
column = "v [mm/s]"
unit = "mm/s"
role = "input"
[signals.friction_force]
column = "F [N]"
unit = "N"
role = "output"
[[trials]]
file = "long{suffix}"
condition = "c1"
"""


def write(folder: Path, megabytes: float, suffix: str) -> None:
    """A recording of at least that size: a clock, a motion, a force, a channel that nobody asks for, and a note in words."""
    folder.mkdir(parents=True)
    (folder / "experiment.toml").write_text(DOCUMENT.format(suffix=suffix))
    path, draw, at = folder / f"long{suffix}", np.random.default_rng(0), 0
    notes = pa.array(["ok"] * ROWS)
    writer = None
    while at == 0 or path.stat().st_size < megabytes * 1e6:
        times = np.arange(at, at + ROWS) * 1e-6
        columns = {"t [s]": times, "v [mm/s]": np.sin(times), "F [N]": draw.standard_normal(ROWS), "spare": draw.standard_normal(ROWS)}
        table = pa.table({**columns, "note": notes})
        if writer is None:
            writer = (pa.parquet.ParquetWriter if suffix == ".parquet" else pa.csv.CSVWriter)(path, table.schema)
        writer.write_table(table)
        at += ROWS
    writer.close()


def read(folder: Path, what: str) -> dict[str, float]:
    model = ContactModel()
    told: list[float] = []
    before, started = peak(), time.perf_counter()
    if what == "scan":
        rows = scan_experiment(folder, model, progress=told.append).trials[0].rows
    elif what == "diagnose":
        experiment = read_experiment(folder, model, progress=told.append, most=CONSTANTS.diagnosed_samples + 1)
        rows = experiment.trials[0].times.size
        diagnose(experiment, model)
    else:
        rows = read_experiment(folder, model, progress=told.append).trials[0].times.size
    seconds = time.perf_counter() - started
    return {"rows": rows, "seconds": seconds, "peak": peak(), "before": before, "told": len(told), "last": told[-1]}


if __name__ == "__main__":
    if sys.argv[1] == "write":
        write(Path(sys.argv[2]), float(sys.argv[3]), sys.argv[4])
    else:
        print(json.dumps(read(Path(sys.argv[2]), sys.argv[1])))
