"""How good are these diagnoses? The proof's table of a folder of answers against the sealed labels, by base form and stratum.

    python tests/gap/second_reality score LABELS ANSWERS [--json FILE]

A missing or unreadable answer counts as wrong wherever it is asked. Some base laws are, in the library's words, an effect of LuGre
(a contact of Maxwell elements: `maxwell_slip`): naming that, alone or beside the truth, is a true statement and counts as one. `strict`
figures allow no such names.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from answers import Answer, read_answer
from location import overlap
from statistics_of_scores import Figure, area_under_curve, calibration_error, mean_of, share_of

from . import catalogue

Label = dict[str, Any]
Cases = list[tuple[Label, Answer]]
Names = frozenset[str]
LEAST = 1.0  # structural rms over the noise of one recording, from which on the proof counts
ROWS: tuple[tuple[str, str, str, str], ...] = (  # key, as printed, targets right | other
    ("singles_exact", "singles exact", "0.90", "0.75"),
    ("singles_strict", "  strict", "", ""),
    ("singles_effect", "  with the verdict effect", "", ""),
    ("singles_top", "  likeliest set, whatever the verdict", "", ""),
    ("family_exact", "singles, family exact", "0.95", "0.85"),
    ("truth_in_set", "truth in the 90 % set", "0.90", "0.87"),
    ("set_size", "size of the 90 % set", "<= 1.6", "<= 2.2"),
    ("wrong_second", "a wrong second one", "<= 0.05", "<= 0.10"),
    ("pairs_exact", "pairs exact", "0.75", "0.50"),
    ("pairs_visible", "  each at 0.5 x noise beside the other", "", ""),
    ("pairs_one", "  at least one of them", "", ""),
    ("false_alarms", "false alarms, ambiguous included", "<= 0.05", "<= 0.10"),
    ("false_alarms_strict", "  strict", "", ""),
    ("false_alarms_effect", "  with the verdict effect", "", ""),
    ("quiet_unknown", "no gap or mistuned called unknown", "", ""),
    ("mistuned", "mistuned recognised", "", ""),
    ("unknown_named", "unknown named as known", "<= 0.10", "<= 0.15"),
    ("unknown_recognised", "unknown recognised", "", ""),
    ("auroc", "AUROC of the novelty", "0.95", "0.90"),
    ("ece", "calibration error (ECE)", "<= 0.06", "<= 0.06"),
    ("place_f1", "place F1", "0.85", "0.75"),
    ("closure", "closure of the oracle", "0.95", "0.85"),
    ("seconds", "seconds, median", "<= 8", "<= 8"),
    ("seconds_95", "seconds, 95 of 100", "<= 20", "<= 20"),
    ("answered", "answered", "1", "1"),
)


def truth(label: Label) -> Names:
    return frozenset(label["effects"])


def meant(names: Iterable[str], label: Label) -> Names:
    """What is claimed beside a true statement on the base law."""
    return frozenset(names) - (frozenset(label["stands_for"]) - truth(label))


def families(names: Names) -> frozenset[str]:
    return frozenset(catalogue.FAMILY.get(name, name) for name in names)


def exact(label: Label, answer: Answer) -> bool:
    return meant(answer.top, label) == truth(label)


def figures(cases: Cases, labels: Path, places: dict[str, float]) -> dict[str, Figure]:
    """Every score of these cases, each a label with the answer to it."""
    single = [(c, a) for c, a in cases if c["truth"] == "single"]
    pairs = [(c, a) for c, a in cases if c["truth"] == "pair"]
    visible = [(c, a) for c, a in pairs if min(c["seen_beside"].values(), default=0.0) > 0.5]
    quiet = [(c, a) for c, a in cases if c["truth"] in ("none", "mistuned")]
    unknown = [(c, a) for c, a in cases if c["truth"] == "unknown"]
    mistuned = [(c, a) for c, a in quiet if c["truth"] == "mistuned"]
    known = [*single, *pairs]
    sure = [(a.confidence, exact(c, a)) for c, a in cases if a.confidence is not None and c["truth"] != "unknown"]
    seconds = [a.seconds for _, a in cases if a.seconds is not None]

    def alarm(c: Label, a: Answer) -> bool:
        return bool(a.failed or meant(a.top, c))

    return {
        "singles_exact": share_of([exact(c, a) for c, a in single]),
        "singles_strict": share_of([a.top == truth(c) for c, a in single]),
        "singles_effect": share_of([a.verdict == "effect" and exact(c, a) for c, a in single]),
        "singles_top": share_of([meant(a.first_effects, c) == truth(c) for c, a in single]),
        "family_exact": share_of([families(meant(a.top, c)) == families(truth(c)) for c, a in single]),
        "truth_in_set": share_of([truth(c) in {meant(s, c) for s in a.likely} for c, a in single]),
        "set_size": mean_of([float(len({meant(s, c) for s in a.likely})) for c, a in single if a.likely]),
        "wrong_second": share_of([truth(c) < meant(a.top, c) for c, a in single]),
        "pairs_exact": share_of([exact(c, a) for c, a in pairs]),
        "pairs_visible": share_of([exact(c, a) for c, a in visible]),
        "pairs_one": share_of([bool(a.top & truth(c)) for c, a in pairs]),
        "false_alarms": share_of([alarm(c, a) for c, a in quiet]),
        "false_alarms_strict": share_of([bool(a.names or a.failed) for _, a in quiet]),
        "false_alarms_effect": share_of([a.verdict == "effect" and alarm(c, a) for c, a in quiet]),
        "quiet_unknown": share_of([a.verdict == "unknown" for _, a in quiet]),
        "mistuned": share_of([a.verdict == "mistuned" for _, a in mistuned]),
        "unknown_named": share_of([alarm(c, a) for c, a in unknown]),
        "unknown_recognised": share_of([a.verdict == "unknown" for _, a in unknown]),
        "auroc": area_under_curve([a.novelty for _, a in unknown], [a.novelty for _, a in known]),
        "ece": calibration_error([p for p, _ in sure], [right for _, right in sure]),
        "place_f1": mean_of([places[c["name"]] for c, _ in known]),
        "closure": mean_of([share for c, a in known if a.names and (share := a.closed(c)) is not None]),
        "seconds": mean_of(seconds, middle=True),
        "seconds_95": mean_of(seconds, quantile=0.95),
        "answered": share_of([not a.failed for _, a in cases]),
    }


def large_enough(label: Label) -> bool:
    """Whether the proof counts this case: a gap of the noise of one recording or more, or none at all."""
    return label["truth"] == "none" or label["ratio"] >= LEAST


def _groups(cases: Cases) -> dict[str, Cases]:
    """Which cases each column of the tables holds. `small` alone counts gaps below the noise."""

    def only(of: Callable[[Label], bool]) -> Cases:
        return [(c, a) for c, a in cases if of(c)]

    counted = only(large_enough)
    groups = {form: [(c, a) for c, a in counted if c["form"] == form] for form in ("right", "other")} | {"all": counted}
    for stratum in (*catalogue.STRATA, "-"):
        for form in ("right", "other"):
            groups[f"stratum {stratum} {form}"] = only(lambda c, s=stratum, f=form: (c["stratum"], c["form"]) == (s, f))  # type: ignore[misc]
    for world in catalogue.WORLDS:
        groups[f"world {world}"] = [(c, a) for c, a in counted if c["kinematics"].split("/")[0] == world]
    for base in sorted({f"{c['law']} + {c['cut']}" for c, _ in counted}):
        groups[f"base {base}"] = [(c, a) for c, a in counted if f"{c['law']} + {c['cut']}" == base]
    for family in sorted({f for c, _ in counted for f in c["families"]}):
        groups[f"family {family}"] = [(c, a) for c, a in counted if c["families"] == [family]]
    for grade in ("good", "ordinary", "bad"):
        groups[f"rig {grade}"] = [(c, a) for c, a in counted if c["set_up"]["grade"] == grade]
    return {name: own for name, own in groups.items() if own}


def score(labels: Path, answers: Path, *, answered_only: bool = False) -> dict[str, Any]:
    """All figures of all groups, the counts of verdicts, and what was said of each case."""
    sealed = json.loads((labels / "labels.json").read_text(encoding="utf-8"))
    cases: Cases = []
    for name, label in sorted(sealed["cases"].items()):
        if answered_only and not (answers / name / "diagnosis.json").is_file():
            continue
        cases.append(({**label, "name": name}, read_answer(answers / name / "diagnosis.json")))
    places = {c["name"]: overlap(c, a, labels)[0] for c, a in cases if c["truth"] in ("single", "pair")}
    groups = _groups(cases)
    return {
        "split": sealed["split"], "cases": len(cases), "failed": {c["name"]: a.failed for c, a in cases if a.failed},
        "counts": {group: len(own) for group, own in groups.items()},
        "figures": {group: {k: f.as_json() for k, f in figures(own, labels, places).items()} for group, own in groups.items()},
        "verdicts": {t: dict(Counter(a.verdict or "none given" for c, a in cases if c["truth"] == t)) for t in catalogue.SHARES},
        "each": {
            c["name"]: {
                "truth": c["truth"], "effects": sorted(c["effects"]) or ([c["unknown"]["kind"]] if c["unknown"] else []), "form": c["form"],
                "law": c["law"], "cut": c["cut"], "stratum": c["stratum"], "ratio": c["ratio"], "kinematics": c["kinematics"],
                "verdict": a.verdict, "top": sorted(a.top), "confidence": a.confidence, "exact": exact(c, a), "seconds": a.seconds,
                "place_f1": places.get(c["name"]),
            }
            for c, a in cases
        },
    }  # fmt: skip


def _columns(scores: dict[str, Any], groups: list[str], rows: Iterable[tuple[str, str, str, str]], targets: bool) -> list[str]:
    own = [group for group in groups if group in scores["figures"]]
    heads = [group.removeprefix("stratum ") for group in own]
    lines = [f"{'':40s} " + " ".join(f"{head[:25]:>25s}" for head in heads) + ("   target right | other" if targets else "")]
    for key, name, right, other in rows:
        cells = [Figure.text(scores["figures"][group][key]) for group in own]
        lines.append(f"{name:40s} " + " ".join(f"{cell:>25s}" for cell in cells) + (f"   {right} | {other}" if targets and right else ""))
    return lines


def table(scores: dict[str, Any]) -> str:
    """The figures as text: value [90 % interval] (count), beside the targets; then by stratum, world, base law and family."""
    few = [
        row for row in ROWS if row[0] in ("singles_exact", "family_exact", "truth_in_set", "pairs_exact", "false_alarms", "unknown_named")
    ]
    lines = [f"{scores['cases']} cases of the split {scores['split']}; gaps of {LEAST:g} x the noise of one recording and more:", ""]
    lines += _columns(scores, ["right", "other", "all"], ROWS, targets=True)
    for title, start in (
        ("By stratum (rms over the noise of one recording) and base form", "stratum "), ("By world", "world "), ("By base law", "base "),
        ("By family of the effect", "family "), ("By quality of the rig", "rig "),
    ):  # fmt: skip
        groups = [group for group in scores["figures"] if group.startswith(start)]
        for k in range(0, len(groups), 6):
            lines += ["", title if k == 0 else "", *_columns(scores, groups[k : k + 6], few, targets=False)]
    lines += [
        "",
        "Verdicts by truth",
        *(f"{t:10s} {', '.join(f'{v}: {n}' for v, n in sorted(c.items()))}" for t, c in scores["verdicts"].items()),
    ]
    return "\n".join([*lines, *(f"{name}: {why}" for name, why in scores["failed"].items())])


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("labels", type=Path, help="folder of the sealed truth")
    parser.add_argument("answers", type=Path, help="folder of NNN/diagnosis.json")
    parser.add_argument("--answered", action="store_true", help="leave out cases that have no answer yet: for a look at a run under way")
    parser.add_argument("--json", type=Path, help="write all figures to this file")


def run(given: argparse.Namespace) -> int:
    with np.errstate(all="ignore"):
        scores = score(given.labels, given.answers, answered_only=given.answered)
    sys.stdout.write(table(scores) + "\n")
    if given.json:
        given.json.write_text(json.dumps(scores, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    return 0
