"""What was checked of an FMU or a system, by which test, in which range, and how far off was it?

An .srmd file tells: Simulation Resource Meta Data of SSP Traceability.
The figures stand in fmus/evidence.toml: the tests write them there and are held to them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache

from evat.files.read_toml import read_toml
from evat.fmu.xml import add, serialised, top
from evat.model import BuildError
from evat.native.compile import source_root

FOLDER = "extra/org.ssp-standard.srmd"
KINDS = ("verification", "validation")
_SRMD = "http://ssp-standard.org/SSPTraceability1/SimulationResourceMetaData"
_STC = "http://ssp-standard.org/SSPTraceability1/SSPTraceabilityCommon"


@dataclass(frozen=True, slots=True)
class Evidence:
    """One check. `kind`: verification, against other computations, or validation, against measurements; `against` names them; `range` is
    where it was made; `largest_deviation` [%] the worst that the `test` has found; `parts` the FMUs and systems that it is of."""

    name: str
    kind: str
    claim: str
    against: str
    range: str
    parts: tuple[str, ...]
    test: str
    largest_deviation: float


@lru_cache
def evidence() -> tuple[Evidence, ...]:
    """All that is known, in the order of the file. BuildError for a key that is missing or not known."""
    path = source_root() / "fmus" / "evidence.toml"
    made, keys = [], {each.name for each in fields(Evidence)}
    for row in read_toml(path)["evidence"]:
        if row.keys() != keys or row["kind"] not in KINDS:
            raise BuildError(f"{path.name}: {row.get('name')}: needed are {', '.join(sorted(keys))}, with a kind of {' or '.join(KINDS)}.")
        made.append(Evidence(**{**row, "parts": tuple(row["parts"])}))
    return tuple(made)


def credibility_files(title: str, part: str, edition: str) -> dict[str, bytes]:
    """The .srmd file of a part or a system, which `edition` tells from others of its title. What was not validated says so."""
    root = top(
        f"{{{_SRMD}}}SimulationResourceMetaData",
        {"version": "1.0.0", "name": title, "description": f"What was checked of {title}, {edition}"},
        {"srmd": _SRMD, "stc": _STC},
    )
    for kind in KINDS:
        known = [each for each in evidence() if each.kind == kind and part in each.parts]
        for each in known:
            _classify(root, kind, {
                "claim": each.claim, "against": each.against, "range": each.range, "test": each.test,
                "largest deviation": f"{each.largest_deviation:g} %",
            })  # fmt: skip
        if not known:
            _classify(root, kind, {"claim": "none that a test holds"})
    return {f"{FOLDER}/{title}.srmd": serialised(root)}


def _classify(root: object, kind: str, entries: dict[str, str]) -> None:
    classification = add(root, f"{{{_STC}}}Classification", {"type": f"org.evat.{kind}"})
    for keyword, content in entries.items():
        add(classification, f"{{{_STC}}}ClassificationEntry", {"keyword": keyword}).text = content
