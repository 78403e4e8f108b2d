"""Which small mistakes do the tests not see? The campaign as a command: one line of JSON for each mistake.

python tests/mutation/mutate.py kernel --count 100 --seed 1 --folder build/out/mutation
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from pathlib import Path

from workshop import PARTS, ROOT, Workshop, campaign, drawn


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--count", type=int, default=50, help="mistakes to draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--file", help="only files whose name contains this")
    parser.add_argument("--folder", type=Path, default=ROOT / "build" / "out" / "mutation", help="for the copy, objects and the journal")
    parser.add_argument("--fmus", type=Path, help="FMUs that the tests of the shells drive, of `evat build --host-only --out FOLDER`")
    parser.add_argument("--longest", type=float, help="tests that take longer [s] are left out")
    parser.add_argument("--minutes", type=float, default=float("inf"), help="no new mistake after so many")
    parser.add_argument("--again", action="store_true", help="those that survived in the journal, with all tests up to --longest")
    parser.add_argument("--tests", nargs="+", help="only these files of tests, in place of all that look at the part")
    given = parser.parse_args()
    begin = time.monotonic()
    workshop, journal = Workshop(given.folder, given.part, given.fmus, given.tests), given.folder / f"{given.part}.jsonl"
    workshop.prepare(given.longest)
    told = [json.loads(line) for line in journal.read_text(encoding="utf-8").splitlines()] if journal.is_file() else []
    last = {(row["file"], row["was"], row["becomes"]): row["verdict"] for row in told}
    some = [mistake for mistake in drawn(given.part, given.count, given.seed) if (given.file or "") in mistake.file]
    some = [m for m in some if (last.get(m.name) == "survived" if given.again else m.name not in last)]
    counts: Counter[str] = Counter()
    with journal.open("a", encoding="utf-8") as stream:
        at = time.monotonic()
        for mistake, verdict, test in campaign(workshop, some, given.longest):
            took, at = time.monotonic() - at, time.monotonic()
            row = {"file": mistake.file, "line": mistake.line, "was": mistake.was, "becomes": mistake.becomes}
            print(json.dumps({**row, "verdict": verdict, "test": test, "seconds": round(took, 1)}), file=stream, flush=True)
            counts[verdict] += 1
            print(f"{verdict:10} {took:5.1f} s  {mistake.file}:{mistake.line}  {mistake.was}  =>  {mistake.becomes}  {test}", flush=True)
            if at - begin > 60 * given.minutes:
                break
    print(dict(counts))
    return 1 if counts["survived"] else 0


if __name__ == "__main__":
    sys.exit(main())
