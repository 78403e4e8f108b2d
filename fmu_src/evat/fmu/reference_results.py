"""What should come out? Results of the default experiment, for a check after import (FMI-LS-REF and the files of the cross-check)."""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from evat.fmu.fmu_facts import FmuFacts
from evat.fmu.xml import add, serialised, text, top
from evat.model import FloatArray

Follow = Callable[[FloatArray, Sequence[str], Mapping[str, FloatArray]], FloatArray]

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
DIGITS = "%.9g"
_NAMESPACE = "http://fmi-standard.org/fmi-ls-manifest"
_MANIFEST = {
    "fmi-ls-name": "org.fmi-standard.fmi-ls-ref",
    "fmi-ls-version": "1.0.0-alpha.1",
    "fmi-ls-description": "Layered Standard providing information on related files included in an FMU.",
}


def _times(fmu_facts: FmuFacts) -> FloatArray:
    first, last, step = (fmu_facts.default_experiment[name] for name in ("startTime", "stopTime", "stepSize"))
    return np.asarray(first + step * np.arange(round((last - first) / step) + 1), dtype=np.float64)


def _motion(fmu_facts: FmuFacts) -> dict[str, FloatArray]:
    """Inputs at these times, as the file holds them."""
    times = _times(fmu_facts)
    waves = fmu_facts.reference_results.get("inputs", {})
    columns = {name: at["mean"] + at["amplitude"] * np.sin(2 * np.pi * at["frequency"] * times) for name, at in waves.items()}
    return {name: np.array([float(DIGITS % value) for value in column]) for name, column in columns.items()}


def _table(times: FloatArray, columns: Mapping[str, FloatArray]) -> bytes:
    stream = io.BytesIO()
    header = ",".join(f'"{name}"' for name in ("time", *columns))
    np.savetxt(stream, np.column_stack((times, *columns.values())), fmt=DIGITS, delimiter=",", header=header, comments="")
    return stream.getvalue()


def _options(fmu_facts: FmuFacts, tolerance: float | None) -> bytes:
    experiment = fmu_facts.default_experiment
    pairs = {"StartTime": experiment["startTime"], "StopTime": experiment["stopTime"], "StepSize": experiment["stepSize"]}
    if tolerance is not None:
        pairs["RelTol"] = tolerance
    return "".join(f"{name}, {text(value)}\n" for name, value in pairs.items()).encode()


def reference_files(fmu_facts: FmuFacts, tolerance: float | None, run: Follow) -> dict[str, bytes]:
    """The folder of the layered standard: manifest, results, options of the run, and the inputs where the run has any.

    run : the columns of these names at these times, from a start at the first, shape (times, names); inputs are held from each time to the
        next, as importers hold them, and all else is at start values.
    """
    times, motion, names = _times(fmu_facts), _motion(fmu_facts), list(fmu_facts.reference_results["columns"])
    rows = run(times, names, motion)
    name = fmu_facts.model_name
    contents = {
        f"{name}_ref.csv": _table(times, dict(zip(names, rows.T, strict=True))),
        f"{name}_ref.opt": _options(fmu_facts, tolerance),
        **({f"{name}_in.csv": _table(times, motion)} if motion else {}),
    }
    identity = {f"{{{_NAMESPACE}}}{key}": value for key, value in _MANIFEST.items()}
    manifest = top("fmiReferences", identity, {"fmi-ls": _NAMESPACE})
    about = (
        ("text/csv", "result", "outputs over the default experiment at start values, from co-simulation"),
        ("text/plain", "configuration", "start, stop, communication step and tolerance of that run"),
        ("text/csv", "input", "inputs of that run, each held from its time to the next; those that are not here stay at their starts"),
    )
    for (name, content), (mime, role, meaning) in zip(contents.items(), about[: len(contents)], strict=True):
        checksum = hashlib.sha3_256(content).hexdigest()
        add(manifest, "Related", {"type": mime, "source": name, "role": role, "description": meaning, "checksum": checksum})
    files = {f"{FOLDER}/{name}": content for name, content in contents.items()}
    files[f"{FOLDER}/fmi-ls-manifest.xml"] = serialised(manifest)
    return files
