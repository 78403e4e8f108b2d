"""How good are these diagnoses? The score table of a folder of them against the sealed labels, for the right and the wrong base form.

    python tests/gap/blind/score.py OUT DIAGNOSES [--json FILE]

OUT is what generate.py made; DIAGNOSES holds NNN/diagnosis.json. A missing or unreadable diagnosis counts as wrong wherever it is asked.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
from answers import Answer, read_answer
from location import overlap
from statistics_of_scores import Figure, area_under_curve, calibration_error, mean_of, share_of

SEEN = 5.0
TARGETS: dict[str, tuple[str, str]] = {
    "top-1, detectable single effect": ("0.95", "0.85"),
    "  of those without a look-alike": ("", ""),
    "  top candidate, whatever the verdict": ("", ""),
    "truth in the 90 % set": ("0.90", "0.87"),
    "size of the 90 % set": ("<= 1.3", "<= 1.8"),
    "pairs exact": ("0.85", "0.70"),
    "  of those of which both can be seen": ("", ""),
    "  pairs with at least one of them": ("", ""),
    "false alarms": ("<= 0.05", "<= 0.10"),
    "mistuned recognised": ("0.95", "0.85"),
    "no gap recognised": ("", ""),
    "open-set AUROC": ("0.95", "0.90"),
    "unknown named as known": ("<= 0.10", "<= 0.20"),
    "unknown recognised": ("", ""),
    "location F1": ("0.85", "0.75"),
    "location IoU": ("0.75", "0.60"),
    "calibration error (ECE)": ("<= 0.05", "<= 0.08"),
    "closure against an oracle": ("0.95", "0.85"),
    "reported gap over true gap": ("1", "1"),
    "seconds, median": ("<= 10", "<= 10"),
    "seconds, 95th percentile": ("<= 30", "<= 30"),
    "answered": ("1", "1"),
}

Cases = list[tuple[dict[str, Any], Answer]]


def figures(cases: Cases, out: Path) -> dict[str, Figure]:
    """Every score of these cases, each a label with the answer to it."""
    single = [(c, a) for c, a in cases if c["truth"] == "single" and c["detectable"]]
    pairs = [(c, a) for c, a in cases if c["truth"] == "pair" and c["detectable"]]
    visible = [(c, a) for c, a in pairs if min(c["seen_beside"].values(), default=0.0) > SEEN]
    quiet = [(c, a) for c, a in cases if c["truth"] in ("none", "mistuned")]
    mistuned = [(c, a) for c, a in cases if c["truth"] == "mistuned" and c["off"] > SEEN]
    unknown = [(c, a) for c, a in cases if c["truth"] == "unknown"]
    known = [*single, *pairs]
    places = [overlap(c, a, out) for c, a in known]
    sure = [(a.confidence, a.top == _names(c)) for c, a in cases if a.confidence is not None and c["truth"] != "unknown"]
    gaps = [ratio for c, a in known if (ratio := a.gap_ratio(c)) is not None]
    seconds = [a.seconds for _, a in cases if a.seconds is not None]
    rows = {
        "top-1, detectable single effect": share_of([a.names and a.top == _names(c) for c, a in single]),
        "  of those without a look-alike": share_of([a.names and a.top == _names(c) for c, a in single if not c["twins"]]),
        "  top candidate, whatever the verdict": share_of([a.first_effects == _names(c) for c, a in single]),
        "truth in the 90 % set": share_of([_names(c) in a.likely for c, a in single]),
        "size of the 90 % set": mean_of([float(len(a.likely)) for c, a in single if a.likely]),
        "pairs exact": share_of([a.names and a.top == _names(c) for c, a in pairs]),
        "  of those of which both can be seen": share_of([a.names and a.top == _names(c) for c, a in visible]),
        "  pairs with at least one of them": share_of([a.names and bool(a.top & _names(c)) for c, a in pairs]),
        "false alarms": share_of([bool(a.names or a.failed) for _, a in quiet]),
        "mistuned recognised": share_of([a.verdict == "mistuned" for _, a in mistuned]),
        "no gap recognised": share_of([a.verdict == "no_gap" for c, a in quiet if c["truth"] == "none" and c["form"] == "right"]),
        "open-set AUROC": area_under_curve([a.novelty for _, a in unknown], [a.novelty for _, a in known]),
        "unknown named as known": share_of([bool(a.names or a.failed) for _, a in unknown]),
        "unknown recognised": share_of([a.verdict == "unknown" for _, a in unknown]),
        "location F1": mean_of([f1 for f1, _ in places]),
        "location IoU": mean_of([iou for _, iou in places]),
        "calibration error (ECE)": calibration_error([p for p, _ in sure], [bool(right) for _, right in sure]),
        "closure against an oracle": mean_of([share for c, a in known if a.names and (share := a.closed(c)) is not None]),
        "reported gap over true gap": mean_of(gaps, middle=True),
        "seconds, median": mean_of(seconds, middle=True),
        "seconds, 95th percentile": mean_of(seconds, quantile=0.95),
        "answered": share_of([not a.failed for _, a in cases]),
    }
    return rows


def _names(label: dict[str, Any]) -> frozenset[str]:
    return frozenset(label["effects"])


def score(out: Path, diagnoses: Path) -> dict[str, Any]:
    """All figures: for both forms together and apart, per stratum, the counts of cases, and what went wrong in single cases."""
    labels = json.loads((out / "labels.json").read_text(encoding="utf-8"))["cases"]
    cases: Cases = []
    for name, label in sorted(labels.items()):
        cases.append(({**label, "name": name}, read_answer(diagnoses / name / "diagnosis.json")))
    groups = {"all": cases} | {form: [one for one in cases if one[0]["form"] == form] for form in ("right", "wrong")}
    groups |= {f"stratum {s}": [one for one in cases if one[0]["stratum"] == s] for s in ("low", "middle", "high")}
    groups |= {
        f"kinematics {k}": [one for one in cases if one[0]["kinematics"].split("/")[0] == k] for k in ("rig", "machine", "ellipse", "means")
    }
    return {
        "cases": len(cases),
        "failed": {c["name"]: a.failed for c, a in cases if a.failed},
        "figures": {group: {k: v.as_json() for k, v in figures(own, out).items()} for group, own in groups.items() if own},
        "each": {
            c["name"]: {"truth": c["truth"], "effects": sorted(c["effects"]), "form": c["form"], "verdict": a.verdict, "top": sorted(a.top)}
            for c, a in cases
        },
    }


def table(scores: dict[str, Any], groups: tuple[str, ...] = ("right", "wrong", "all")) -> str:
    """The figures as text: value [interval] (count), beside the targets for right | wrong."""
    own = [group for group in groups if group in scores["figures"]]
    lines = [f"{'score':40s} " + " ".join(f"{group:>27s}" for group in own) + "   target right | wrong"]
    for name, (right, wrong) in TARGETS.items():
        cells = [Figure.text(scores["figures"][group][name]) for group in own]
        lines.append(f"{name:40s} " + " ".join(f"{cell:>27s}" for cell in cells) + (f"   {right} | {wrong}" if right else ""))
    lines += [f"{scores['cases']} cases", *(f"{name}: {why}" for name, why in scores["failed"].items())]
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("diagnoses", type=Path)
    parser.add_argument("--json", type=Path, help="write all figures to this file")
    given = parser.parse_args(arguments)
    scores = score(given.out, given.diagnoses)
    sys.stdout.write(table(scores) + "\n")
    if given.json:
        given.json.write_text(json.dumps(scores, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    np.seterr(all="ignore")
    raise SystemExit(main())
