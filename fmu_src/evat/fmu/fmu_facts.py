"""What does an FMU show beside its model's tables? Names, capabilities, terminals: the file fmus/PART.toml."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields
from pathlib import Path
from typing import Any, Literal

from evat.files.read_toml import read_toml
from evat.fmu.xml import Scalar
from evat.model import BuildError

Version = Literal[2, 3]
TOLERANCE = "relative_tolerance"  # the parameter that is FMI's tolerance, where a model has it


@dataclass(frozen=True, slots=True)
class FmuFacts:
    """The facts of one FMU that are neither physics nor behaviour; the fields are the keys of the file, `part` is its name.

    An FMU may carry the `model` of another part with other values at the `start`: choices that its use needs, which some importers cannot
    set. It may be slim: of the model's variables it has those that are `shown`, and all others stand at their starts; none named: all.
    Of the model's outputs those that are `connected` are outputs of the FMU, and the others are local: recorded by name, fed to nobody;
    none named: all are outputs.
    """

    part: str
    model_name: str
    description: str
    license: str
    default_experiment: Mapping[str, float]
    log_categories: Mapping[str, str]
    quantities: Mapping[str, str]
    fmi2: Mapping[str, Mapping[str, Scalar]]
    fmi3: Mapping[str, Mapping[str, Scalar]]
    terminals: list[Mapping[str, Any]]
    reference_results: Mapping[str, Any]  # columns; inputs that are waves, by name: mean, amplitude, frequency [Hz]
    model: str
    start: Mapping[str, float | str] = field(default_factory=dict)
    shown: list[str] = field(default_factory=list)
    connected: list[str] = field(default_factory=list)

    def interfaces(self, version: Version) -> Mapping[str, Mapping[str, Scalar]]:
        """The interface elements of one FMI version with their attributes."""
        return self.fmi2 if version == 2 else self.fmi3


def load(path: Path) -> FmuFacts:
    """Read the file; a key that is missing or not known is an error. What many FMUs share stands in a second file, named by `as_in`."""
    facts = read_toml(path)
    if "as_in" in facts:
        facts = {**read_toml(path.with_name(facts.pop("as_in"))), **facts}
    facts = {"part": path.stem, "model": path.stem, **facts}
    known = {each.name for each in fields(FmuFacts)}
    wanted = {each.name for each in fields(FmuFacts) if each.default is MISSING and each.default_factory is MISSING}
    if not wanted <= facts.keys() <= known:
        missing, unknown = sorted(wanted - facts.keys()), sorted(facts.keys() - known)
        raise BuildError(f"{path.name}: keys missing: {missing}; keys not known: {unknown}. Correct the file.")
    return FmuFacts(**facts)
