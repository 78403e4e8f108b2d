"""How do the files of a diagnosis appear? Made in a folder beside, moved into place whole; never half."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from evat.files.writing import OutputError, as_output_error, scratch, usable
from evat.gap.answer import FORMAT, Diagnosis
from evat.gap.report import corrected
from evat.gap.report.html_report import page
from evat.gap.search.compare import Comparison
from evat.gap.verdict.judgement import fitted
from evat.plots.experiment_page import REPORTS, pages_on

if TYPE_CHECKING:
    from evat.gap.report.fmu_run import FmuRun

JSON, REPORT = "diagnosis.json", "report.html"
FILES = (JSON, REPORT, corrected.SSV)


def write_diagnosis(
    answer: Diagnosis, comparison: Comparison, out: Path, *, fmu: Path | None = None, without: str = "it was not asked for"
) -> tuple[Path, ...]:
    """diagnosis.json, report.html and corrected.ssv in the folder `out`, which holds nothing else; a diagnosis that is there is replaced.

    Parameters
    ----------
    fmu : the component as an FMU; the report then shows what it gives with corrected.ssv.
    without : where there is none: why, for the report.

    Raises
    ------
    OutputError where `out` is something else, or cannot be written; then it is as it was.
    """
    out = Path(os.path.abspath(out))
    _check_free(out)
    with as_output_error(out, "the diagnosis"), scratch(out.parent) as folder:
        made = folder / "new"
        made.mkdir()
        others = pages_on(comparison.prediction.experiment, out / REPORT, REPORTS[JSON])
        _fill(answer, comparison, made, fmu, without, others)
        _into_place(made, out, folder / "old")
    return tuple(out / name for name in FILES)


def check_place(out: Path) -> None:
    """OutputError where something stands there that is no diagnosis, or nothing can be written: asked before minutes of work."""
    _check_free(out)
    usable(Path(os.path.abspath(out)).parent)


def _check_free(out: Path) -> None:
    """OutputError where something stands there that is no diagnosis: nothing of a user's is replaced."""
    if not os.path.lexists(out):
        return
    if out.is_symlink() or not out.is_dir():
        raise OutputError(f"{out}: this is no folder; name a new one, or one that holds a diagnosis.")
    there = sorted(entry.name for entry in out.iterdir())
    if not there or (_is_diagnosis(out / JSON) and set(there) <= set(FILES)):
        return
    foreign = [name for name in there if name not in FILES] or there
    listed = ", ".join(foreign[:3]) + (f" and {len(foreign) - 3} more" if len(foreign) > 3 else "")
    raise OutputError(f"{out}: this folder is no diagnosis and would be replaced as a whole; it holds {listed}. Name a new folder.")


def _is_diagnosis(path: Path) -> bool:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return isinstance(document, dict) and document.get("format") == FORMAT and "verdict" in document


def _fill(answer: Diagnosis, comparison: Comparison, folder: Path, fmu: Path | None, without: str, beside: Mapping[str, str]) -> None:
    ssv = corrected.write(answer, comparison, folder)
    run: FmuRun | None = None
    if fmu is not None:
        from evat.gap.report.fmu_run import run_fmu  # brings fmpy

        chosen = fitted(comparison, answer.judgement.chosen)
        run = run_fmu(fmu, ssv, comparison, chosen, answer.closure.held_out_conditions)
    (folder / JSON).write_text(answer.json(), encoding="utf-8")
    (folder / REPORT).write_text(page(answer, comparison, run, without, beside), encoding="utf-8")


def _into_place(made: Path, out: Path, old: Path) -> None:
    """By renaming alone; what was there comes back where the second of two renames fails."""
    made.chmod(0o755)
    if not os.path.lexists(out):
        os.rename(made, out)
        return
    os.rename(out, old)
    try:
        os.rename(made, out)
    except BaseException:
        os.rename(old, out)
        raise
