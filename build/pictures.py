"""How are the guide's pictures of identification, of two time scales, of the paper's table 2 and of the notebooks made?

.venv/bin/python build/pictures.py writes them; the same sources, the same bytes.
Of the others feed-force.png comes out of `python3 build/run.py`; record.png, diagnosis.png and speed-ratio.png of commands that stand
beside them in the guide.
"""

from __future__ import annotations

import os
import re
import tempfile
from pathlib import Path

import numpy as np
from evat import parameter_sets
from evat.guide.notebooks import BLOCK, PICTURE, PREFIX
from evat.identification.report.figures import save_profiles
from evat.studies import recovery
from evat.studies.coupling import study
from evat.studies.paper.plots import plot_profiles, plot_table
from evat.studies.paper.study import study_paper
from evat.studies.recovery_plot import plot_recovery
from evat.studies.two_scales.plot import plot_coupling, plot_two_scales
from evat.studies.two_scales.study import TwoScales, changing_speed, compare
from matplotlib.figure import Figure

FOLDER = Path(__file__).resolve().parent.parent / "fmu_src" / "guide" / "pictures"
MATERIAL, MOTION = "regularised/al-7075-t6", "ramp"  # the paper's own tests


def cut(step: float) -> TwoScales:
    times = np.arange(round(2 / step) + 1, dtype=np.float64) * step
    return compare(times, changing_speed(times))


def two_time_scales() -> None:
    others = [cut(step) for step in (1e-4, 2e-4, 5e-4, 1e-3, 2e-3, 5e-3)]
    print(plot_two_scales(others[3], others, FOLDER / "two-time-scales.png"))
    coupling = study((1e-4, 2e-4, 5e-4, 1e-3, 2e-3))
    print(plot_coupling(coupling.steps, coupling.error, coupling.made, FOLDER / "coupling.png"))


def paper_tables() -> None:
    paper = study_paper()
    print(plot_table(paper, FOLDER / "table-2.png"))
    print(plot_profiles(paper, FOLDER / "paper-profiles.png"))


def notebooks() -> None:
    """Each block is run; the figure that it ends in, or the last that it made, is what the picture below it shows."""
    for page in sorted(FOLDER.parent.glob(f"{PREFIX}*.md")):
        names: dict[str, object] = {"__name__": "__main__"}
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            parts = BLOCK.split(page.read_text(encoding="utf-8"))
            for code, text in zip(parts[1::2], parts[2::2], strict=True):
                *before, last = code.rstrip().splitlines()
                shown = last if re.match(r"\w+(\[[^]]*\])?\.plot\(", last) else "figure" if ".savefig(" in last else None
                exec("\n".join([*before, "" if shown == last else last]), names)
                if link := PICTURE.match(text):
                    figure = eval(shown or "None", names)
                    assert isinstance(figure, Figure), f"{page.name}: {last} gives no figure"
                    figure.savefig(FOLDER.parent / link[1], dpi=80, metadata={"Software": None})
                    print(FOLDER.parent / link[1])
            os.chdir(FOLDER)


def main() -> None:
    notebooks()
    two_time_scales()
    paper_tables()
    forecasts = [recovery.recovery(parameter_sets.load(name)) for name in recovery.study_sets()]
    print(plot_recovery(forecasts, FOLDER / "recovery.png"))
    identification = recovery.fitted(parameter_sets.load(MATERIAL), MOTION, rate=500.0, seed=1)
    print(save_profiles(identification, FOLDER / "identify-profiles.png"))


if __name__ == "__main__":
    main()
