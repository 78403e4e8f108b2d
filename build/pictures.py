"""How are the guide's pictures of identification, of two time scales and of the paper's table 2 made?

.venv/bin/python build/pictures.py writes them; the same sources, the same bytes.
Of the others feed-force.png comes out of `python3 build/run.py`; record.png, diagnosis.png and speed-ratio.png of commands that stand
beside them in the guide.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from evat import parameter_sets
from evat.identification.report.figures import save_profiles
from evat.studies import recovery
from evat.studies.coupling import study
from evat.studies.paper.plots import plot_profiles, plot_table
from evat.studies.paper.study import study_paper
from evat.studies.recovery_plot import plot_recovery
from evat.studies.two_scales.plot import plot_coupling, plot_two_scales
from evat.studies.two_scales.study import TwoScales, changing_speed, compare

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


def main() -> None:
    two_time_scales()
    paper_tables()
    forecasts = [recovery.recovery(parameter_sets.load(name)) for name in recovery.study_sets()]
    print(plot_recovery(forecasts, FOLDER / "recovery.png"))
    identification = recovery.fitted(parameter_sets.load(MATERIAL), MOTION, rate=500.0, seed=1)
    print(save_profiles(identification, FOLDER / "identify-profiles.png"))


if __name__ == "__main__":
    main()
