"""Which cases is a gap diagnosis judged on? Makes experiments of the second reality, and keeps their truth apart from them.

    python tests/gap/second_reality generate CASES --labels LABELS --split development --seed 1 --count 60

CASES/NNN/ is an experiment each; LABELS/labels.json holds what was put in, LABELS/oracle/NNN.parquet the forces without errors.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import zlib
from collections import Counter
from collections.abc import Iterator
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from . import catalogue, folder
from .draw import Case, NotDrawn, Plan, draw_case

RIVALS = ({"edge_force", "size_effect"}, {"thermal_softening", "proxy_lag"}, {"stribeck", "rate_and_state"})
OTHER = 0.5  # share of cases whose base law is of another form


class Plans:
    """What there is to choose from, in turn: every list is gone through in a mixed order before it begins again."""

    def __init__(self, rng: np.random.Generator, split: str, only: dict[str, list[str]]) -> None:
        self.rng, self.split = rng, split
        self.worlds = [w for w in catalogue.WORLDS if w in (only.get("world") or catalogue.WORLDS)]
        self.truths = [t for t in catalogue.SHARES if t in (only.get("truth") or catalogue.SHARES)]
        self.strata = [s for s, times in catalogue.TIMES.items() for _ in range(times) if s in (only.get("stratum") or catalogue.STRATA)]
        self.effects = only.get("effect") or list(catalogue.EFFECTS)
        self.forms = only.get("form") or ["right", "other"]
        self.pools: dict[str, list[Any]] = {}

    def take(self, key: str, every: list[Any]) -> Any:
        if not every:
            raise SystemExit(f"there is nothing to choose for {key}; allow more worlds, effects or truths.")
        if not self.pools.get(key):
            self.pools[key] = [every[k] for k in self.rng.permutation(len(every)).tolist()]
        return self.pools[key].pop()

    def world(self) -> str:
        weights = np.array([catalogue.WORLDS[w] for w in self.worlds])
        return str(self.rng.choice(self.worlds, p=weights / weights.sum()))

    def own(self, world: str) -> list[str]:
        return [name for name in catalogue.effects(world) if name in self.effects]

    def plan(self, truth: str) -> Plan:
        stratum, form = self.take("stratum " + truth, self.strata), self.take("form " + truth, self.forms)
        world, names = self.world(), ()
        if truth == "single":
            name = self.take("effects", [n for n in self.effects if any(n in self.own(w) for w in self.worlds)])
            world, names = self.take(f"world of {name}", [w for w in self.worlds if name in self.own(w)]), (name,)
        elif truth == "pair":
            pairs = [both for both in combinations(self.own(world), 2) if set(both) not in RIVALS]
            names = self.take(f"pairs {world}", pairs)
        elif truth == "unknown":
            names = (self.take(f"unknown {world}", catalogue.unknowns(self.split, world)),)
        law, cut = "lugre", "sharp"
        if form == "other":
            laws, cuts = catalogue.laws(self.split), catalogue.cuts(self.split)
            if "lugre" in {n for name in names if name in catalogue.EFFECTS for n in catalogue.EFFECTS[name].needs}:
                laws = [one for one in laws if one.startswith("lugre")]
            if world in ("ellipse", "means"):
                inside = [c for c in cuts if not catalogue.stands_for("", c) & set(names)]
                cut = self.take(f"cut {world}", cuts) if len(inside) == len(cuts) else (inside[0] if inside else "sharp")
                if cut == "sharp" or self.rng.random() < 0.3:
                    law = self.take("law of a cut", [one for one in laws if one in ("lugre_variant", "lugre_presliding")])
            else:
                laws = [one for one in laws if not catalogue.stands_for(one, "") & set(names)]
                law = self.take(f"law {' '.join(laws)}", laws)
        return Plan(world, truth, tuple(names), stratum, law, cut)

    def all(self, count: int) -> Iterator[Plan]:
        """Truths in their shares, in a mixed order."""
        share = np.array([catalogue.SHARES[t] for t in self.truths])
        numbers = np.floor(share / share.sum() * count).astype(int)
        numbers[np.argsort(-share)[: count - int(numbers.sum())]] += 1
        drawn = [t for t, n in zip(self.truths, numbers.tolist(), strict=True) for _ in range(n)]
        for k in self.rng.permutation(len(drawn)).tolist():
            yield self.plan(drawn[k])


def drawn(plan: Plan, plans: Plans, seed: list[int]) -> tuple[Case, list[str]]:
    """The plan, some times; then others of its truth, form and stratum; and why those before did not come off."""
    why: list[str] = []
    for attempt in range(120):
        if attempt and attempt % 6 == 0:
            other = plans.plan(plan.truth)
            if other.form != plan.form:
                continue
            plan = Plan(other.world, other.truth, other.effects, plan.stratum, other.law, other.cut)
        try:
            return draw_case(plan, plans.split, [*seed, attempt]), why
        except NotDrawn as reason:
            why.append(f"{plan.world} {' '.join(plan.effects)} {plan.stratum}: {reason}")
    raise SystemExit(f"case {seed} does not come off: {'; '.join(why[-3:])}. Allow more worlds, effects or strata.")


def plain(value: Any) -> Any:
    """For JSON: numbers to ten digits."""
    if isinstance(value, dict):
        return {str(k): plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v) for v in value]
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (float, np.floating)):
        return float(f"{float(value):.10g}")
    return int(value) if isinstance(value, np.integer) else value


def begun(cases: Path, labels: Path, made_by: dict[str, Any]) -> dict[str, Any]:
    """The labels of the cases that an earlier run with the same arguments has finished."""
    sealed = labels / "labels.json"
    if not sealed.is_file():
        if any(place.exists() and any(place.iterdir()) for place in (cases, labels)):
            raise SystemExit(f"{cases} or {labels} is there and holds something else; name new folders.")
        return {}
    sealed_already = dict(json.loads(sealed.read_text(encoding="utf-8")))
    if {k: v for k, v in sealed_already.items() if k not in ("cases", "cases_to_come")} != made_by:
        raise SystemExit(f"{labels} was begun with other arguments; name a new folder.")
    return dict(sealed_already["cases"])


def seed_of(split: str, seed: int, place: int) -> list[int]:
    """Numbers of a case; no seed of one split gives a case of the other."""
    return [zlib.crc32(split.encode()), seed, place + 1]


def generate(cases: Path, labels: Path, split: str, seed: int, count: int, only: dict[str, list[str]]) -> Counter[str]:
    """Writes everything, going on where a run that was broken off stood; how many of what."""
    if labels.resolve() == cases.resolve() or labels.resolve().is_relative_to(cases.resolve()):
        raise SystemExit(f"the labels ({labels}) would lie among the cases ({cases}); name a folder apart from them.")
    made_by = plain({"format": 1, "split": split, "seed": seed, "count": count, "only": only, "strata": catalogue.STRATA})
    done = begun(cases, labels, made_by)
    (labels / "oracle").mkdir(parents=True, exist_ok=True)
    plans = Plans(np.random.default_rng(seed_of(split, seed, -1)), split, only)
    for place, plan in enumerate(list(plans.all(count))):
        name = f"{place + 1:03d}"
        if name in done:
            continue
        others = Plans(np.random.default_rng([*seed_of(split, seed, place), 1]), split, only)
        case, why = drawn(plan, others, seed_of(split, seed, place))
        shutil.rmtree(cases / name, ignore_errors=True)
        folder.write(cases / name, case, np.random.default_rng([*seed_of(split, seed, place), 2]))
        folder.save(labels / "oracle" / f"{name}.parquet", case.oracle)
        done[name] = plain({**case.label, "attempts": len(why) + 1})
        sealed = {**made_by, "cases": done, "cases_to_come": count - place - 1}
        (labels / "labels.new").write_text(json.dumps(sealed, indent=1, sort_keys=True) + "\n", encoding="utf-8")
        (labels / "labels.new").replace(labels / "labels.json")
    facts = (("", "truth"), ("form ", "form"), ("stratum ", "stratum"), ("world ", "kinematics"), ("law ", "law"))
    return Counter(prefix + label[key].split("/")[0] for label in done.values() for prefix, key in facts)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("cases", type=Path, help="folder of the experiments to make")
    parser.add_argument("--labels", type=Path, required=True, help="folder of the sealed truth, apart from the cases")
    parser.add_argument("--split", choices=catalogue.SPLITS, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    choices = {
        "truth": list(catalogue.SHARES), "stratum": list(catalogue.STRATA), "world": list(catalogue.WORLDS),
        "effect": list(catalogue.EFFECTS), "form": ["right", "other"],
    }  # fmt: skip
    for key, every in choices.items():
        parser.add_argument(f"--{key}", choices=every, action="append", help="only this (repeatable)")


def run(given: argparse.Namespace) -> int:
    only = {key: getattr(given, key) or [] for key in ("truth", "stratum", "world", "effect", "form")}
    numbers = generate(given.cases, given.labels, given.split, given.seed, given.count, only)
    sys.stdout.write(", ".join(f"{name}: {number}" for name, number in sorted(numbers.items())) + "\n")
    return 0
