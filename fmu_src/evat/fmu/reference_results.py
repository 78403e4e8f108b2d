"""What should come out? Results of the default experiment, for a check after import (FMI-LS-REF and the files of the cross-check)."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Sequence

import numpy as np

from evat.fmu.fmu_facts import FmuFacts
from evat.fmu.xml import add, serialised, text, top
from evat.model import FloatArray

Follow = Callable[[FloatArray, Sequence[str]], FloatArray]

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_MANIFEST = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}


def _table(fmu_facts: FmuFacts, run: Follow) -> bytes:
    experiment, columns = fmu_facts.default_experiment, list(fmu_facts.reference_results["columns"])
    first, last, step = (experiment[name] for name in ("startTime", "stopTime", "stepSize"))
    times = np.asarray(first + step * np.arange(round((last - first) / step) + 1), dtype=np.float64)
    values = run(times, columns)
    stream = io.BytesIO()
    header = ",".join(f'"{name}"' for name in ("time", *columns))
    np.savetxt(stream, np.column_stack((times, values)), fmt="%.9g", delimiter=",", header=header, comments="")
    return stream.getvalue()


def _options(fmu_facts: FmuFacts, tolerance: float | None) -> bytes:
    experiment = fmu_facts.default_experiment
    pairs = {"StartTime": experiment["startTime"], "StopTime": experiment["stopTime"], "StepSize": experiment["stepSize"]}
    if tolerance is not None:
        pairs["RelTol"] = tolerance
    return "".join(f"{name}, {text(value)}\n" for name, value in pairs.items()).encode()


def reference_files(fmu_facts: FmuFacts, tolerance: float | None, run: Follow) -> dict[str, bytes]:
    """The folder of the layered standard: manifest, results, options of the run.

    run : the columns of these names at these times, from a start at the first, all at start values, shape (times, names).
    """
    contents = {
        f"{fmu_facts.model_name}_ref.csv": _table(fmu_facts, run),
        f"{fmu_facts.model_name}_ref.opt": _options(fmu_facts, tolerance),
    }
    identity = {f"{{{_NAMESPACE}}}{key}": value for key, value in _MANIFEST.items()}
    manifest = top("fmiReferences", identity, {"fmi-ls": _NAMESPACE})
    about = (
        ("text/csv", "result", "outputs over the default experiment at start values, from co-simulation"),
        ("text/plain", "configuration", "start, stop, communication step and tolerance of that run"),
    )
    for (name, content), (mime, role, meaning) in zip(contents.items(), about, strict=True):
        checksum = hashlib.sha3_256(content).hexdigest()
        add(manifest, "Related", {"type": mime, "source": name, "role": role, "description": meaning, "checksum": checksum})
    files = {f"{FOLDER}/{name}": content for name, content in contents.items()}
    files[f"{FOLDER}/fmi-ls-manifest.xml"] = serialised(manifest)
    return files
