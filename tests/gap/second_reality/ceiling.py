"""How often could one be right who knows everything but the effect? The ceiling of the proof's table on the single effects of some cases.

    python tests/gap/second_reality ceiling LABELS [--json FILE]

Who knows the base law's true form, every effect's true laws, the noise and how far set-up and parameters may be off tells the truth from
its nearest rival with the probability Phi(delta/2), delta: what the rival at its best leaves of the gap, in standard deviations of all
records together. Parameters, gain, zero and clock of each channel, and those of each condition, are free within their priors; a rival's
strength is, too, and so is it whether there is any effect at all.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm
from statistics_of_scores import Figure, mean_of

from . import catalogue, draw, recording
from .drive import Array, Channels
from .world import Effect, World

Row = dict[str, Any]
SEARCHES = 3


class Records:
    """The whitened records of a case: one lane for each condition, weighted by its repeats."""

    def __init__(self, truth: draw.Truth, label: dict[str, Any]) -> None:
        self.world, self.bench, self.label, shared = truth.world, truth.bench, label, label["set_up"]
        self.colour = 0.0 if self.world.means else float(shared["colour"])
        self.weight = [np.sqrt(max(n, 1)) for n in label["repeats"]]
        self.unit = {n: self.bench.unit[n] * shared["noise"][n] for n in self.world.channels}
        columns, sd = self._nuisances(shared)
        self.N = columns * sd  # a square root of the covariance that nuisances add
        self.inner = np.linalg.inv(np.eye(sd.size) + self.N.T @ self.N)

    def row(self, parts: list[Channels]) -> Array:
        """In standard deviations of independent numbers."""
        out = []
        for name in self.world.channels:
            for part, weight in zip(parts, self.weight, strict=True):
                x = part[name] / self.unit[name] * weight
                a = self.colour
                out.append(x if x.size == 1 else np.concatenate([x[:1], (x[1:] - a * x[:-1]) / np.sqrt(1 - a * a)]))
        return np.concatenate(out)

    def _nuisances(self, shared: dict[str, Any]) -> tuple[Array, Array]:
        """What may be off, and by how much: the base law's parameters; gain, zero and clock of channels and of conditions in them."""
        world, plain = self.world, self.bench.plain
        columns, sd = [], []
        base = self.row(plain)
        for name in world.free:
            moved = world.clean({**world.params, name: world.params[name] * 1.01})
            columns.append((self.row(moved) - base) / 0.01)
            sd.append(world.sd[name])
        q = recording.GRADES[shared["grade"]]
        for name in world.channels:
            force = self.bench.unit[name]
            for lane in (None, *range(len(plain))):
                own = shared["trial_gain"] / self.weight[lane or 0], shared["trial_zero"] / self.weight[lane or 0], shared["trial_clock"]
                sizes = (0.01 * q, 0.006 * q, recording.CLOCK[shared["grade"]]) if lane is None else own
                for what, size in zip(("gain", "zero", "clock"), sizes, strict=True):
                    if world.means and (what == "clock" or lane is not None):
                        continue
                    column = self.row([
                        {n: self._off(part[n], what, force) if n == name and lane in (None, k) else 0.0 * part[n] for n in part}
                        for k, part in enumerate(plain)
                    ])  # fmt: skip
                    columns.append(column)
                    sd.append(size)
        return np.stack(columns, axis=1), np.array(sd)

    @staticmethod
    def _off(force: Array, what: str, unit: float) -> Array:
        if what == "gain":
            return force
        return np.full_like(force, unit) if what == "zero" else np.gradient(force)

    def freed(self, r: Array) -> Array:
        """A row whose norm is the Mahalanobis distance of r by noise and nuisances together."""
        used = self.inner @ (self.N.T @ r)
        return np.concatenate([r - self.N @ used, used])


def possible(world: World, name: str, law: str) -> bool:
    """Whether an effect could be claimed of this record at all."""
    needs, d = catalogue.EFFECTS[name].needs, world.conditions
    if world.kind.split("/")[0] not in catalogue.EFFECTS[name].worlds or ("theta" in needs and "proxy_source" not in world.exact):
        return False
    if ("load" in needs and d.load is None and d.thickness is None) or ("lugre" in needs and not law.startswith("lugre")):
        return False
    return ("thermal_softening" in world.nominal_effects) == ("softened" in needs) or "theta" not in needs


def left_by(records: Records, effect: Effect, gap: Array) -> float:
    """Distance that is left at the best strength of a rival."""
    world, plain = records.world, records.row(records.bench.plain)
    best = float(np.linalg.norm(records.freed(gap)))
    for sign in (1.0, -1.0) if effect.both_ways else (1.0,):
        s = effect.typical
        for _ in range(SEARCHES):
            with np.errstate(all="ignore"):
                column = records.freed(records.row(world.clean(acting=[(effect, sign * s)])) - plain)
            if not np.all(np.isfinite(column)) or not float(column @ column):
                break
            whole = records.freed(gap)
            share = max(float(column @ whole) / float(column @ column), 0.0)
            best = min(
                best, float(np.linalg.norm(whole - share * column)) if 0.3 < share < 3 else np.inf, float(np.linalg.norm(whole - column))
            )
            if not share or 0.8 < share < 1.25:
                break
            s = float(np.clip(s * share, max(effect.least, 1e-4 * effect.most), effect.most))
    return best


def told_apart(label: dict[str, Any]) -> Row:
    """The truth's distance from no effect, from its nearest rival and from the nearest of another family."""
    plan = draw.Plan(**{**label["plan"], "effects": tuple(label["plan"]["effects"])})
    truth = draw.truth_of(plan, label["split"], np.random.default_rng(label["seed"]))
    records, world = Records(truth, label), truth.world
    gap = records.row(world.clean(acting=truth.acting)) - records.row(truth.bench.plain)
    delta = {"": float(np.linalg.norm(records.freed(gap)))}
    for name in catalogue.effects(world.kind.split("/")[0]):
        if name in label["effects"] or name in label["stands_for"] or not possible(world, name, label["law"]):
            continue
        for place, make in enumerate(m for split in catalogue.SPLITS for m in catalogue.forms(split, name).values()):
            effect = make(world, np.random.default_rng([7, place]))
            delta[name] = min(delta.get(name, np.inf), left_by(records, effect, gap))
    nearest = min(delta, key=lambda n: delta[n])
    others = {n: q for n, q in delta.items() if catalogue.FAMILY.get(n, "") not in label["families"]}
    return {
        "seen": delta[""], "nearest": nearest, "delta": delta[nearest], "right": float(norm.cdf(delta[nearest] / 2)),
        "family_right": float(norm.cdf(min(others.values()) / 2)), "form": label["form"], "stratum": label["stratum"],
    }  # fmt: skip


def table(rows: dict[str, Row]) -> str:
    lines = [f"{'ceiling of':26s} {'singles exact':>26s} {'family exact':>26s}"]
    groups = {f"{f}, from 1 x noise": [r for r in rows.values() if r["form"] == f and r["stratum"] != "small"] for f in ("right", "other")}
    groups |= {
        f"{s} {f}": [r for r in rows.values() if (r["form"], r["stratum"]) == (f, s)] for s in catalogue.STRATA for f in ("right", "other")
    }
    for name, own in groups.items():
        cells = [Figure.text(mean_of([r[key] for r in own]).as_json()) for key in ("right", "family_right")]
        lines.append(f"{name:26s} " + " ".join(f"{cell:>26s}" for cell in cells))
    return "\n".join(lines)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("labels", type=Path, help="folder of the sealed truth")
    parser.add_argument("--json", type=Path, help="write every case's figures to this file; it is sealed, too")


def run(given: argparse.Namespace) -> int:
    rows: dict[str, Row] = {}
    if given.json and given.json.is_file():  # goes on where it stood
        rows = json.loads(given.json.read_text(encoding="utf-8"))
    sealed = json.loads((given.labels / "labels.json").read_text(encoding="utf-8"))["cases"]
    for name, label in sorted(sealed.items()):
        if label["truth"] != "single" or name in rows:
            continue
        rows[name] = told_apart(label)
        if given.json:
            given.json.write_text(json.dumps(rows, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    sys.stdout.write(table(rows) + "\n")
    return 0
