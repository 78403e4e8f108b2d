"""What does the diagnosis say of a folder of cases? Runs `evat diagnose` on each, several at a time, and goes on where it stood.

python tests/gap/second_reality run CASES ANSWERS --jobs 2
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

LIMIT = 600.0  # seconds for one case


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cases", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("--jobs", type=int, default=1, help="cases at a time, each on one core")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds after which a case is given up")
    parser.add_argument("--again", action="store_true", help="also the cases that failed before")


def diagnose(case: Path, answer: Path, limit: float) -> str:
    """ "done", or why there is no answer; what the command printed lies in answer.log beside the answer's folder."""
    answer.parent.mkdir(parents=True, exist_ok=True)
    one_core = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
    command = [sys.executable, "-m", "evat", "diagnose", str(case), "--out", str(answer), "--no-fmu", "--threads", "1"]
    try:
        finished = subprocess.run(
            command, capture_output=True, text=True, timeout=limit, env={**os.environ, **one_core}, check=False, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired:
        answer.with_suffix(".log").write_text(f"given up after {limit:g} s\n", encoding="utf-8")
        return f"given up after {limit:g} s"
    answer.with_suffix(".log").write_text(finished.stdout + finished.stderr, encoding="utf-8")
    if finished.returncode or not (answer / "diagnosis.json").is_file():
        return (finished.stderr.strip() or finished.stdout.strip() or "no output").splitlines()[-1]
    return "done"


def run(given: argparse.Namespace) -> int:
    cases = [case for case in sorted(given.cases.iterdir()) if (case / "experiment.toml").is_file()]
    if not cases:
        raise SystemExit(f"{given.cases}: there is no experiment in it; name a folder that `generate` made.")
    to_do = [
        case
        for case in cases
        if not (given.answers / case.name / "diagnosis.json").is_file()
        and (given.again or not (given.answers / f"{case.name}.log").is_file())
    ]
    failed = 0

    def one(case: Path) -> tuple[str, str, float]:
        began = time.monotonic()
        return case.name, diagnose(case, given.answers / case.name, given.limit), time.monotonic() - began

    with ThreadPoolExecutor(max(given.jobs, 1)) as pool:
        for name, said, seconds in pool.map(one, to_do):
            failed += said != "done"
            sys.stdout.write(f"{name}: {said}, {seconds:.1f} s\n")
            sys.stdout.flush()
    sys.stdout.write(f"{len(cases)} cases, {len(cases) - len(to_do)} answered before, {failed} failed now\n")
    return int(failed > 0)
