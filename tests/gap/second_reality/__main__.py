"""Which step of the second reality is wanted: generate cases, run the diagnosis on them, score its answers, find the ceiling, or carry out
what it advises?"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "blind")]  # beside this package: how answers and places are read


def main(arguments: list[str] | None = None) -> int:
    import numpy as np

    from second_reality import advised, ceiling, generate, run_diagnosis, scores

    parser = argparse.ArgumentParser(prog="second_reality", description=(__doc__ or "").splitlines()[0])
    steps = parser.add_subparsers(required=True)
    for name, module in (("generate", generate), ("run", run_diagnosis), ("score", scores), ("ceiling", ceiling), ("advised", advised)):
        step = steps.add_parser(name, help=(module.__doc__ or "").splitlines()[0], description=(module.__doc__ or "").splitlines()[0])
        module.add_arguments(step)
        step.set_defaults(run=module.run)
    given = parser.parse_args(arguments)
    with np.errstate(all="ignore"):
        return int(given.run(given))


if __name__ == "__main__":
    raise SystemExit(main())
