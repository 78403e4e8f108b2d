"""What does a friction rig record in ten minutes at 100 kHz? Programs that repeat themselves, holds, transients, noise that goes on, wear.

python long_record.py FOLDER ROWS writes it; python long_record.py FOLDER compress|identify|diagnose does that and tells time and memory.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
from evat.answers import diagnose, identify
from evat.experiment.compression import compress_experiment
from evat.identification import Settings
from evat.model import FloatArray
from evat.models.contact import ContactModel
from evat.native.kernel import Contact
from scipy.signal import lfilter

RATE, AT_ONCE = 100_000, 1 << 20  # Hz, rows
TRUTH: dict[str, float | str] = {
    "kinematics": "external", "friction_law": "lugre", "F_C": 9.0, "F_S": 11.0, "sigma0": 1e5, "sigma1": 300.0, "sigma2": 40.0, "v_s": 0.01,
    "friction_wear.delta": 0.2, "friction_wear.s_0": 10.0,
}  # fmt: skip
WHITE, SLOW, MEMORY = 0.1, 0.05, 0.999  # N, N, from row to row: 10 ms
DOCUMENT = """format = 1
title = "Ten minutes of a rig"
[nominal]
friction = "lugre"
kinematics = "external"
effects = []
values = { F_C = 8.0, F_S = 12.0, sigma0 = 8e4, sigma1 = 200.0, sigma2 = 50.0, v_s = 0.012 }
relative_sd = { F_C = 0.3, F_S = 0.3, sigma0 = 0.5, sigma1 = 0.5, sigma2 = 0.5, v_s = 0.5 }
[signals]
time = { column = "t [s]", unit = "s" }
slip_velocity = { column = "v [mm/s]", unit = "mm/s", role = "input" }
friction_force = { column = "F [N]", unit = "N", role = "output" }
[[trials]]
file = "long.parquet"
condition = "c1"
"""


def motion(rows: int) -> FloatArray:
    """Of `rows` at RATE: running up, a program of 1 s over and over, held, another program, held, the first again, at rest."""
    phase = 2 * np.pi * np.arange(RATE) / RATE
    first, second = 0.05 * np.sin(phase) + 0.02 * np.sin(3 * phase), 0.12 * np.sin(phase)
    pieces = [np.linspace(0.0, 0.03, rows // 50)]
    for program, share in ((first, 0.33), (None, 0.1), (second, 0.25), (None, 0.1), (first, 0.2)):
        count = int(share * rows)
        pieces.append(np.full(count, 0.04) if program is None else np.tile(program, count // RATE))
    whole = np.concatenate(pieces)
    return np.concatenate([whole, np.zeros(max(rows - whole.size, 0))])[:rows]


def write(folder: Path, rows: int) -> None:
    folder.mkdir(parents=True)
    (folder / "experiment.toml").write_text(DOCUMENT)
    velocity, draw, memory = motion(rows), np.random.default_rng(1), np.zeros(1)
    contact = Contact({**TRUTH, "slip_velocity": float(velocity[0])}, ["friction_wear"])
    contact.start(0.0)
    schema = pa.schema([("t [s]", pa.float64()), ("v [mm/s]", pa.float64()), ("F [N]", pa.float32())])
    with pa.parquet.ParquetWriter(folder / "long.parquet", schema) as writer:
        for first in range(0, rows, AT_ONCE):
            own = np.arange(first, min(first + AT_ONCE, rows))
            run = own if not first else np.concatenate([[first - 1], own])
            force = contact.run(run / RATE, {"slip_velocity": velocity[run]}, ["friction_force"])[-own.size :, 0]
            slow, memory = lfilter([np.sqrt(1 - MEMORY**2)], [1.0, -MEMORY], draw.standard_normal(own.size), zi=memory)
            force += WHITE * draw.standard_normal(own.size) + SLOW * slow
            writer.write_table(pa.table([own / RATE, 1e3 * velocity[own], force.astype(np.float32)], schema=schema))


def measured(folder: Path, what: str) -> dict[str, object]:
    import resource

    begin, answer = time.process_time(), dict[str, object]()
    if what == "compress":
        answer["told"] = str(compress_experiment(folder).told[0])
    elif what == "identify":
        settings = Settings(on=("friction_wear",), bounds={"friction_wear.delta": (-0.5, 3.0)}, search="none", profiles=False)
        free = ("F_C", "F_S", "sigma0", "sigma1", "sigma2", "v_s", "friction_wear.delta")
        result = identify(folder, ContactModel(1), free, settings)
        answer["estimates"] = {each.name: (each.value, each.sd) for each in result.estimates}
    else:
        result_ = diagnose(folder, ContactModel(1))
        answer |= {"verdict": result_.verdict, "effects": [each.name for each in result_.effects]}
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)
    return {**answer, "seconds": time.process_time() - begin, "peak": peak}


if __name__ == "__main__":
    if sys.argv[2] in ("compress", "identify", "diagnose"):
        print(json.dumps(measured(Path(sys.argv[1]), sys.argv[2])))
    else:
        write(Path(sys.argv[1]), int(sys.argv[2]))
