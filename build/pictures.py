"""How are the README's pictures of identification made? .venv/bin/python build/pictures.py writes them; the same sources, the same bytes.

The other two come out of `python3 build/run.py` and of the README's `evat run --record`.
"""

from __future__ import annotations

from pathlib import Path

from evat import parameter_sets, recovery
from evat.identify.figures import save_profiles
from evat.plot_recovery import plot_recovery

FOLDER = Path(__file__).resolve().parent / "pictures"
MATERIAL, MOTION = "regularised/al-7075-t6", "ramp"  # the paper's own tests


def main() -> None:
    forecasts = [recovery.recovery(parameter_sets.load(name)) for name in recovery.study_sets()]
    print(plot_recovery(forecasts, FOLDER / "recovery.png"))
    found = recovery.fitted(parameter_sets.load(MATERIAL), MOTION, rate=500.0, seed=1)
    print(save_profiles(found, FOLDER / "identify-profiles.png"))


if __name__ == "__main__":
    main()
