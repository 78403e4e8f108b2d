"""Which blind cases is a gap diagnosis tried on? Makes experiments with a known cause, and keeps the causes apart from them.

    python tests/gap/blind/generate.py OUT --seed 1 --count 60

OUT/cases/NNN/ is an experiment each; OUT/labels.json holds what was put in, OUT/oracle/NNN.parquet the forces without noise.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from draw import BY_KIND, CAUSES, RIVALS, STRATA, Case, NotDrawn, draw_case
from folder import save, write
from radau import Array
from strangers import FOR_MEANS, STRANGERS
from where import everything

SHARES = {"single": 0.42, "mistuned": 0.15, "none": 0.14, "unknown": 0.15, "pair": 0.14}
KINDS = {"rig": 0.35, "machine": 0.2, "ellipse": 0.3, "means": 0.15}
CHOSEN: dict[str, Any] = {"truth": SHARES, "stratum": STRATA, "kinematics": KINDS, "cause": CAUSES}
Plan = tuple[str, str, tuple[str, ...], str, bool]  # kind, truth, causes, stratum, wrong form


class Choice:
    """What there is to choose from, in turn: every list is gone through in a mixed order before it begins again."""

    def __init__(self, rng: np.random.Generator, only: dict[str, list[str]]) -> None:
        self.rng = rng
        self.truths, self.strata, self.kinds, causes = (only.get(key) or list(every) for key, every in CHOSEN.items())
        self.pools: dict[str, list[Any]] = {}
        own = {kind: [name for name in BY_KIND[kind] if name in causes] for kind in self.kinds}
        self.sets: dict[str, list[Any]] = {
            "single": [(kind, (name,)) for kind in self.kinds for name in own[kind]],
            "pair": [(kind, both) for kind in self.kinds for both in combinations(own[kind], 2) if set(both) not in RIVALS],
            "unknown": [(kind, (name,)) for kind in self.kinds for name in (FOR_MEANS if kind == "means" else STRANGERS)],
        }

    def take(self, key: str, every: list[Any]) -> Any:
        if not self.pools.get(key):
            self.pools[key] = [every[k] for k in self.rng.permutation(len(every)).tolist()]
        return self.pools[key].pop()

    def kind(self) -> str:
        weights = np.array([KINDS[kind] for kind in self.kinds])
        return str(self.rng.choice(self.kinds, p=weights / weights.sum()))

    def plan(self, truth: str, wrong: bool) -> Plan:
        """A case of that truth. Causes that only some kinds of motion have come as often as others; kinds else by their weights."""
        stratum = self.take("stratum " + truth, self.strata)
        if truth == "single":
            kind, names = self.take("single", self.sets["single"])
        elif truth in self.sets:
            kind = self.kind()
            kind, names = self.take(f"{truth} {kind}", [one for one in self.sets[truth] if one[0] == kind])
        else:
            kind, names = self.kind(), ()
        return kind, truth, names, stratum, wrong

    def plans(self, count: int) -> Iterator[Plan]:
        """Truths in their shares, in a mixed order."""
        share = np.array([SHARES[truth] for truth in self.truths])
        numbers = np.floor(share / share.sum() * count).astype(int)
        numbers[0] += count - int(numbers.sum())
        drawn = [truth for truth, number in zip(self.truths, numbers.tolist(), strict=True) for _ in range(number)]
        for k in self.rng.permutation(len(drawn)).tolist():
            yield self.plan(drawn[k], bool(self.take("form " + drawn[k], [True, False])))

    def tries(self, plan: Plan) -> Iterator[Plan]:
        """The plan, some times; in other strata; then others of its truth and form: not every cause can be seen everywhere."""
        kind, truth, names, stratum, wrong = plan
        for other in [stratum, *(s for s in self.strata if s != stratum)]:
            yield from [(kind, truth, names, other, wrong)] * 12
        for _ in range(40):
            yield from [self.plan(truth, wrong)] * 4


def drawn(plans: Iterator[Plan], seed: int, place: int) -> tuple[Case, np.random.Generator, int]:
    """The first that comes off, with its generator of numbers as it stands then, and how many did not."""
    for attempt, plan in enumerate(plans):
        rng = np.random.default_rng([seed, place + 1, attempt])
        try:
            return draw_case(*plan, rng), rng, attempt
        except NotDrawn:
            continue
    raise SystemExit(f"case {place + 1} does not come off; choose from more causes, strata or motions.")


def oracle(case: Case) -> dict[str, Array]:
    """One row per sample (of averages: per condition): where it is, and each channel with and without the causes and after the refit."""
    world = case.setup.world
    rows: dict[str, list[Array]] = {f"at {name}": parts for name, parts in everything(world).items()}
    rows["condition"] = []
    for place in range(len(world.scenes)):
        length = case.clean["with"][place][world.channels[0]].size
        rows["condition"].append(np.full(length, place + 1.0))
        for which, forces in case.clean.items():
            for name in world.channels:
                rows.setdefault(f"{name} {which}", []).append(forces[place][name])
    return {name: np.concatenate(parts) for name, parts in rows.items()}


def plain(value: Any) -> Any:
    """For JSON: numbers to ten digits, arrays as lists."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        return float(f"{float(value):.10g}")
    return int(value) if isinstance(value, np.integer) else value


def begun(out: Path, made_by: dict[str, Any]) -> dict[str, Any]:
    """The labels of the cases that an earlier run with the same arguments has finished."""
    sealed = out / "labels.json"
    if not sealed.is_file():
        if out.exists() and any(out.iterdir()):
            raise SystemExit(f"{out} is there and holds something else; name a new folder.")
        return {}
    sealed_already = dict(json.loads(sealed.read_text(encoding="utf-8")))
    if sealed_already.pop("cases_to_come") == 0 or {k: v for k, v in sealed_already.items() if k != "cases"} != made_by:
        raise SystemExit(f"{out} is finished, or was begun with other arguments; name a new folder.")
    return dict(sealed_already["cases"])


def generate(out: Path, seed: int, count: int, only: dict[str, list[str]]) -> Counter[str]:
    """Writes everything, going on where a run that was broken off stood; how many of what."""
    made_by = plain({"format": 1, "seed": seed, "count": count, "only": {k: v or [] for k, v in only.items()}, "strata": STRATA})
    labels = begun(out, made_by)
    choice = Choice(np.random.default_rng([seed, 0]), only)
    (out / "oracle").mkdir(parents=True, exist_ok=True)
    for place, planned in enumerate(choice.plans(count)):
        name = f"{place + 1:03d}"
        if name in labels:
            continue
        others = Choice(np.random.default_rng([seed, 0, place + 1]), only)
        case, rng, failed = drawn(others.tries(planned), seed, place)
        shutil.rmtree(out / "cases" / name, ignore_errors=True)
        write(out / "cases" / name, f"Record {name}", case.setup, case.nominal, case.recorded, rng)
        save(out / "oracle" / f"{name}.parquet", oracle(case))
        labels[name] = plain({**case.label, "attempts": failed + 1})
        sealed = {**made_by, "cases": labels, "cases_to_come": count - place - 1}
        (out / "labels.new").write_text(json.dumps(sealed, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        (out / "labels.new").replace(out / "labels.json")
    facts = (("", "truth"), ("form ", "form"), ("stratum ", "stratum"), ("kinematics ", "kinematics"))
    return Counter(prefix + label[key].split("/")[0] for label in labels.values() for prefix, key in facts)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    for key, every in CHOSEN.items():
        parser.add_argument(f"--{key}", choices=list(every), action="append", help="only this (repeatable)")
    options = parser.parse_args(arguments)
    numbers = generate(options.out, options.seed, options.count, {key: getattr(options, key) for key in CHOSEN})
    sys.stdout.write(", ".join(f"{name}: {number}" for name, number in sorted(numbers.items())) + "\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
