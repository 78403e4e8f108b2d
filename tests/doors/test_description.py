"""Does an FMU say of itself what the kernel's tables say, and is what it says of its structure true?"""

from __future__ import annotations

import ctypes
import hashlib
import io
import math
import random
import re
import zipfile
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath

import fmpy
import numpy as np
import pytest
from evat import fmu
from evat.files.writing import OutputError
from evat.fmu import archive
from evat.fmu.fmu_facts import load
from evat.fmu.part_model import fmu_facts_of, token_of
from evat.model import EvatError, SimulationError, Variable
from evat.native import kernel
from evat.native.compile import CONTACT, compile_library, fmi_headers, host_target
from evat.native.kernel import Contact
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.model_description import ModelDescription, read_build_description
from fmpy.validation import validate_fmu
from lxml import etree, html

SCHEMAS = Path(fmpy.__file__).parent / "schema"
TYPES = {
    2: {"real": "Real", "integer": "Integer", "boolean": "Boolean", "choice": "Enumeration"},
    3: {"real": "Float64", "integer": "Int32", "boolean": "Boolean", "choice": "Enumeration"},
}


ONE = pytest.mark.parametrize("version", [pytest.param(2, marks=pytest.mark.campaign), 3], scope="module")  # each compiles for long


@pytest.fixture(scope="module", params=[2, 3])
def version(request: pytest.FixtureRequest) -> int:
    return int(request.param)


@pytest.fixture(scope="module")
def path(version: int, fmi2_fmu: Path, fmi3_fmu: Path) -> Path:
    return {2: fmi2_fmu, 3: fmi3_fmu}[version]


@pytest.fixture(scope="module")
def description(path: Path) -> ModelDescription:
    """Read and checked once for each version: that takes seconds."""
    return read_model_description(str(path), validate=True, validate_variable_names=True, validate_model_structure=True)


def content(path: Path, name: str) -> bytes:
    with zipfile.ZipFile(path) as opened:
        return opened.read(name)


# ---- the tables, word for word ----


def test_checkers_find_nothing(path: Path) -> None:
    assert validate_fmu(str(path)) == []


def test_every_variable_is_told_as_the_table_has_it(version: int, description: ModelDescription) -> None:
    rows, told = kernel.variables(), description.modelVariables
    connected = fmu_facts_of().connected
    assert [v.name for v in told] == [v.name for v in rows]
    for row, described in zip(rows, told, strict=True):
        assert described.valueReference == row.index + 1, row.name  # its place in the list, counted from 1
        assert described.type == TYPES[version][row.type], row.name
        kept_inside = row.causality == "output" and row.name not in connected
        assert described.causality == ("local" if kept_inside else row.causality), row.name
        assert described.variability == row.variability, row.name
        assert described.description == f"{row.meaning} [{row.source}]", row.name
        if row.type == "real":
            assert described.unit == row.unit, row.name
            assert described.displayUnit == row.display_unit, row.name
            assert float(described.nominal or 1) == row.nominal, row.name
            assert (described.derivative.name if described.derivative else None) == row.derivative_of, row.name
        if row.type in ("real", "integer"):
            assert float(described.min or -math.inf) == row.min, row.name
            assert float(described.max or math.inf) == row.max, row.name


@pytest.mark.parametrize("part", fmu.parts())
def test_references_are_places_so_that_dependencies_read_alike_by_both(version: int, part: str, fmus: dict[str, Path]) -> None:
    """FMI 3 names dependencies by value reference, FMI 2 by place from 1 on, and importers are about that mix them up."""
    root = etree.fromstring(content(fmus[f"fmi{version}" if part == CONTACT else f"{part}-fmi{version}"], "modelDescription.xml"))
    references = [int(v.get("valueReference")) for v in root.find("ModelVariables")]
    assert references == list(range(1, len(references) + 1))
    named = {int(number) for u in root.find("ModelStructure").iter() for number in (u.get("dependencies") or "").split()}
    assert named
    assert named <= set(references)


def test_starts_are_told_where_a_start_may_be_set(description: ModelDescription) -> None:
    for row, described in zip(kernel.variables(), description.modelVariables, strict=True):
        if row.causality in ("parameter", "input") or row.name in kernel.states():
            assert described.initial == "exact", row.name
            number = {"true": 1.0, "false": 0.0}.get(described.start) if row.type == "boolean" else float(described.start)
            assert number == row.start + (row.type == "choice"), row.name  # items of FMI count from 1
        else:
            assert described.start is None, row.name
            assert described.initial == (None if row.causality == "independent" else "calculated"), row.name


def test_choices_are_enumerations_with_a_word_on_each_item(description: ModelDescription) -> None:
    laws = {law.name: law.meaning for law in kernel.laws()}
    for row, described in zip(kernel.variables(), description.modelVariables, strict=True):
        if row.type != "choice":
            continue
        items = described.declaredType.items
        assert [item.name for item in items] == list(row.choices)
        assert [int(item.value) for item in items] == list(range(1, len(row.choices) + 1))
        words = [item.description for item in items]
        assert all(words), row.name
        assert len(set(words)) == len(words), row.name
        if row.name == "friction_law":
            assert words == list(laws.values())


def test_token_and_model_identifier_bind_binary_and_description(description: ModelDescription) -> None:
    assert description.guid == token_of(2 if description.fmiVersion == "2.0" else 3, fmu.fmu_facts_of())
    assert description.coSimulation.modelIdentifier == description.modelExchange.modelIdentifier == description.modelName
    assert description.generationDateAndTime.endswith("Z")


# What a person knows of these units; the description has it from pint.
@pytest.mark.parametrize(
    ("name", "exponents"),
    [
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
        ("N.s/m", {"kg": 1, "s": -1}),
        ("N.s", {"kg": 1, "m": 1, "s": -1}),
        ("W", {"kg": 1, "m": 2, "s": -3}),
        ("rad", {"rad": 1}),
        ("K", {"K": 1}),
        ("1", {}),
    ],
)
def test_units_by_their_si_exponents(description: ModelDescription, name: str, exponents: dict[str, int]) -> None:
    base = next(unit for unit in description.unitDefinitions if unit.name == name).baseUnit
    assert {part: getattr(base, part) for part in ("kg", "m", "s", "A", "K", "mol", "cd", "rad") if getattr(base, part)} == exponents
    assert (base.factor, base.offset) == (1, 0)  # the kernel is in SI


@pytest.mark.parametrize(
    ("unit", "value", "display", "shown"),
    [
        ("K", 300.0, "degC", 26.85),
        ("rad", math.pi, "deg", 180.0),
        ("m/s", 1.0, "m/min", 60.0),
        ("m", 5e-6, "um", 5.0),
        ("N/m", 1e6, "N/um", 1.0),
        ("Pa", 4e8, "MPa", 400.0),
    ],
)
def test_display_units_by_known_values(description: ModelDescription, unit: str, value: float, display: str, shown: float) -> None:
    definition = next(u for u in description.unitDefinitions if u.name == unit)
    part = next(d for d in definition.displayUnits if d.name == display)
    assert part.factor * value + part.offset == pytest.approx(shown, rel=1e-14)  # rounding of one product and one sum


# ---- the model structure, against the kernel itself ----


def drawn(variable: Variable, luck: random.Random) -> float:
    """Any value of an order that occurs; the tests draw by rules of their own."""
    if variable.type != "real":
        return float(luck.randint(int(variable.min), int(variable.max)))
    size = max(abs(variable.start), variable.nominal if variable.start == 0 else 0.0)
    value = luck.choice((variable.start, luck.gauss(0, 1) * size, luck.uniform(0.3, 3) * size, 10 ** luck.uniform(-4, 0.5) * size))
    return min(max(value, variable.min), variable.max)


class Point:
    """A random contact at a random moment."""

    def __init__(self, seed: int) -> None:
        self.luck = random.Random(seed)
        self.contact = Contact()
        switches, on = {effect.name: effect for effect in kernel.effects()}, set()
        share = self.luck.choice((0.1, 0.5))
        for name in self.luck.sample(sorted(switches), len(switches)):
            if self.luck.random() < share and not any(name in switches[one].rivals or one in switches[name].rivals for one in on):
                on.add(name)
        for variable in kernel.variables():
            if variable.name in switches:
                self.contact.set(variable.name, variable.name in on)
            elif variable.causality in ("parameter", "input") or variable.name in kernel.states():
                self.contact.set(variable.name, drawn(variable, self.luck))
        if self.contact.get("chip_flow_angle") or share > 0.1:
            self.contact.set("initial_state", "at_rest")  # else one start may take a second,
            self.contact.set("averaging", "resolved")  # of either
        self.time = self.luck.uniform(0, 1e-3)
        self.fresh = self.contact.state()

    def change(self, known: Variable) -> None:
        if known.causality == "independent":
            self.contact.time += self.luck.uniform(0, 2) / self.contact.get("vibration_frequency")
        else:
            self.contact.set(known.name, drawn(known, self.luck))

    def run(self) -> bytes:
        """Started, moved on, with new inputs and states."""
        self.contact.start(self.time)
        for variable in kernel.variables():
            if variable.causality in ("independent", "input") or variable.name in kernel.states():
                self.change(variable)
        self.contact.event()
        return self.contact.state()

    def seen(self, names: tuple[str, ...]) -> list[tuple[float, float]]:
        """Values in continuous time, and after an event."""
        self.contact.evaluate()
        before = [self.contact.get(name) for name in names]
        self.contact.event()
        return list(zip(before, (self.contact.get(name) for name in names), strict=True))


@lru_cache(maxsize=64)
def reactions(count: int, seed: int, knowns: tuple[Variable, ...], unknowns: tuple[str, ...]) -> set[tuple[str, str]]:
    """Which unknown reacted to which known, at random points."""
    reacting = set()
    for number in range(count):
        point = Point(seed + number)
        try:
            here = point.run()
            base = point.seen(unknowns)
            if any(before != after for before, after in base):
                continue  # an event is just due, and a rounding decides on which side it ends
            for known in knowns:
                point.contact.restore(here)
                point.change(known)
                reacting |= {(name, known.name) for name, old, new in zip(unknowns, base, point.seen(unknowns), strict=True) if new != old}
        except SimulationError:
            continue
    return reacting


def listed(unknowns: list[object]) -> set[tuple[str, str]]:
    return {(u.variable.name, known.name) for u in unknowns for known in u.dependencies}  # type: ignore[attr-defined]


def running_knowns() -> tuple[Variable, ...]:
    states = kernel.states()
    return tuple(v for v in kernel.variables() if v.causality in ("independent", "input") or v.name in states)


@ONE
def test_what_is_not_listed_does_not_react(description: ModelDescription) -> None:
    states = kernel.states()
    unknowns = [*description.outputs, *description.derivatives, *description.eventIndicators]
    names = tuple(sorted({u.variable.name for u in unknowns} - set(states)))
    reacted = reactions(400, 1000, running_knowns(), names)
    assert reacted - listed(unknowns) == set()
    assert len(reacted) > 150  # else the points were dull, and nothing was shown


@pytest.mark.slow
@pytest.mark.parametrize("one_in", [10, pytest.param(35, marks=pytest.mark.campaign)])
def test_what_is_listed_reacts_somewhere(fmi2_fmu: Path, one_in: int) -> None:
    """All but one in so many: what takes one choice, one effect and one motion together, or a moment 1e-9 of a period before an event, to
    which the swing of a holder leads, is seldom drawn."""
    description = read_model_description(str(fmi2_fmu))
    states = kernel.states()
    claimed = {pair for pair in listed([*description.outputs, *description.derivatives]) if pair[0] not in states}
    knowns, missing = running_knowns(), set(claimed)
    for round_ in range(30):
        names = tuple(sorted({unknown for unknown, _ in missing}))
        wanted = {known for _, known in missing}
        missing -= reactions(100, 50_000 + 100 * round_, tuple(v for v in knowns if v.name in wanted), names)
        if len(missing) <= len(claimed) // one_in:
            break
    assert len(missing) <= len(claimed) // one_in, missing
    assert len(claimed) > 150


@lru_cache(maxsize=1)
def reactions_of_the_start(count: int, seed: int, unknowns: tuple[str, ...]) -> set[tuple[str, str]]:
    """Which unknown, read after a start, reacted to which known that was set before it."""
    knowns = [v for v in kernel.variables() if v.causality in ("independent", "input", "parameter") or v.name in kernel.states()]
    reacting = set()
    for number in range(count):
        point = Point(seed + number)
        try:
            point.contact.start(point.time)
            base = [point.contact.get(name) for name in unknowns]
            for known in point.luck.sample(knowns, 25):
                point.contact.restore(point.fresh)
                point.contact.time = point.time
                point.change(known)
                if point.contact.get("chip_flow_angle") and point.contact.get("initial_state"):
                    continue  # see Point
                point.contact.start(point.contact.time)
                reacting |= {(name, known.name) for name, old in zip(unknowns, base, strict=True) if point.contact.get(name) != old}
        except SimulationError:
            continue
    return reacting


@ONE
def test_what_is_not_listed_for_the_start_does_not_react(description: ModelDescription) -> None:
    reacted = reactions_of_the_start(150, 9000, tuple(u.variable.name for u in description.initialUnknowns))
    assert reacted - listed(description.initialUnknowns) == set()
    assert len(reacted) > 200


def test_states_follow_themselves_alone(description: ModelDescription) -> None:
    for unknown in description.outputs:
        if unknown.variable.name in kernel.states():
            assert [known.name for known in unknown.dependencies] == [unknown.variable.name]
            assert unknown.dependenciesKind == ["constant"]


def test_derivatives_are_those_of_the_states_in_order(description: ModelDescription) -> None:
    assert tuple(u.variable.derivative.name for u in description.derivatives) == kernel.states()


def test_event_indicators_are_variables_in_fmi3(fmi2_fmu: Path, fmi3_fmu: Path) -> None:
    told = read_model_description(str(fmi3_fmu)).eventIndicators
    assert tuple(u.variable.name for u in told) == kernel.indicators()
    assert int(read_model_description(str(fmi2_fmu)).numberOfEventIndicators) == len(kernel.indicators())


def test_factor_of_a_tunable_dependency_is_that_of_its_equation(description: ModelDescription) -> None:
    """T d theta/dt = theta_source - theta: linear in the source, with a factor 1/T that may be tuned."""
    rate = next(u for u in description.derivatives if u.variable.name == "proxy_lag.theta_rate")
    kinds = dict(zip((known.name for known in rate.dependencies), rate.dependenciesKind, strict=True))
    assert kinds["proxy_speed"] == "tunable"
    contact = Contact({"proxy_source": "proxy_speed", "proxy_speed": 0.3, "proxy_lag.time_constant": 0.02}, on=["proxy_lag"])
    contact.start()
    assert contact.derivative("proxy_lag.theta_rate", "proxy_speed") == pytest.approx(1 / 0.02, rel=1e-6)  # differences


@ONE
def test_linear_kinds_are_linear(description: ModelDescription) -> None:
    """constant, fixed: one factor for all points of one choice of fixed parameters."""
    claims = tuple(
        (u.variable.name, known.name)
        for u in (*description.outputs, *description.derivatives)
        for known, kind in zip(u.dependencies, u.dependenciesKind, strict=True)
        if kind in ("constant", "fixed") and u.variable.name not in kernel.states()
    )
    assert claims
    all_are_linear(claims)


@lru_cache(maxsize=1)
def all_are_linear(claims: tuple[tuple[str, str], ...]) -> None:
    """Both versions of FMI claim the same, so it is looked at once."""
    unknowns = {known: [unknown for unknown, other in claims if other == known] for _, known in claims}
    looked = dict.fromkeys(claims, 0)
    for number in range(40):
        point, factors = Point(70 + number), {claim: list[float]() for claim in claims}
        try:
            for _ in range(3):
                here = point.run()
                for known, names in unknowns.items():
                    point.contact.restore(here)
                    rows = []
                    for _ in range(2):
                        point.change(kernel.variable(known))
                        point.contact.evaluate()
                        rows.append((point.contact.get(known), [point.contact.get(name) for name in names]))
                    (x, y), (x_2, y_2) = rows
                    if abs(x - x_2) > 1e-3 * abs(x):  # else rounding decides
                        for place, name in enumerate(names):
                            factors[name, known].append((y[place] - y_2[place]) / (x - x_2))
        except SimulationError:
            continue
        for claim, own in factors.items():
            looked[claim] += len(own) > 1
            assert own == pytest.approx(own[:1] * len(own), rel=1e-9), claim
    assert min(looked.values()) > 10, looked


# ---- the archive ----


def test_archive_is_plain(path: Path) -> None:
    with zipfile.ZipFile(path) as opened:
        entries = opened.infolist()
    names = [entry.filename for entry in entries]
    assert names == sorted(set(names))
    for entry in entries:
        parts = PurePosixPath(entry.filename).parts
        assert "\\" not in entry.orig_filename
        assert ":" not in entry.filename
        assert not entry.filename.startswith("/")
        assert ".." not in parts
        assert entry.external_attr >> 16 == 0o100644  # a file: no folder, no link
        assert entry.compress_type in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        assert entry.date_time == entries[0].date_time


@pytest.mark.parametrize("name", ["../evil", "/etc/evil", "a/../../evil", "a\\b", "c:evil", "", "a//b", "./a"])
def test_no_path_leads_outside(tmp_path: Path, name: str) -> None:
    with pytest.raises(fmu.BuildError, match="not a path inside"):
        archive.write({"modelDescription.xml": b"", name: b"x"}, tmp_path / "out.fmu")
    assert list(tmp_path.iterdir()) == []


def test_failed_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    output = archive.write({"a": b"old"}, tmp_path / "out.fmu")
    old = output.read_bytes()

    def full(*_: object, **__: object) -> None:
        raise OSError("no space left")

    monkeypatch.setattr(zipfile.ZipFile, "writestr", full)
    with pytest.raises(OutputError, match="no space left"):
        archive.write({"a": b"new"}, output)
    assert output.read_bytes() == old
    assert [p.name for p in tmp_path.iterdir()] == ["out.fmu"]


@pytest.mark.parametrize("part", [pytest.param(CONTACT, marks=pytest.mark.campaign), "spindle"])
@ONE
def test_two_builds_give_the_same_bytes(version: int, part: str, tmp_path: Path) -> None:
    target = [host_target().fmi3_folder]
    first, second = (fmu.build_fmu(version, tmp_path / name, target, part=part).read_bytes() for name in ("one.fmu", "two.fmu"))  # type: ignore[arg-type]
    assert hashlib.sha256(first).digest() == hashlib.sha256(second).digest()


@ONE
def test_source_date_epoch_is_the_date(version: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    output = fmu.build_fmu(version, tmp_path / "out.fmu", [host_target().fmi3_folder], part="spindle")  # type: ignore[arg-type]
    assert read_model_description(str(output)).generationDateAndTime == "2023-11-14T22:13:20Z"
    assert "of 2023-11-14" in html.fromstring(content(output, "documentation/index.html")).find_class("about")[0].text_content()
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "tomorrow")
    with pytest.raises(fmu.BuildError, match="SOURCE_DATE_EPOCH"):
        archive.write({}, tmp_path / "none.fmu")


def test_a_compiler_that_is_missing_is_told_before_work_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The dependencies of all variables were worked out first, which takes minutes."""
    said: list[str] = []
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(EvatError, match="no C compiler"):
        fmu.build_fmu(2, tmp_path / "out.fmu", progress=said.append, part="spindle")
    assert said == []


def test_bad_orders_are_refused(tmp_path: Path) -> None:
    with pytest.raises(EvatError, match="targets are x86_64-linux"):
        fmu.build_fmu(3, tmp_path / "out.fmu", ["sparc-solaris"])
    with pytest.raises(EvatError, match="version 2 or 3"):
        fmu.build_fmu(1, tmp_path / "out.fmu")  # type: ignore[arg-type]
    with pytest.raises(EvatError, match="without any binary"):
        fmu.build_fmu(2, tmp_path / "out.fmu", [])
    assert list(tmp_path.iterdir()) == []


def test_table_of_what_is_shown_has_no_stray_keys(tmp_path: Path) -> None:
    (tmp_path / "odd.toml").write_text('model_name = "A"\nmodel_nmae = "B"\n')
    with pytest.raises(fmu.BuildError, match="model_nmae"):
        load(tmp_path / "odd.toml")


# ---- what travels along ----


@pytest.mark.parametrize("part", fmu.parts())
def test_every_xml_of_every_fmu_fits_the_schema_of_its_standard(version: int, part: str, fmus: dict[str, Path]) -> None:
    """The schemas as the standard publishes them, by libxml2: a checker may forgive what other importers refuse."""
    packed = fmus[f"fmi{version}" if part == CONTACT else f"{part}-fmi{version}"]
    schemas = {
        "modelDescription.xml": f"fmi{version}/fmi{version}ModelDescription.xsd",
        "sources/buildDescription.xml": "fmi3/fmi3BuildDescription.xsd",  # FMI 2 has none of its own
        "terminalsAndIcons/terminalsAndIcons.xml": "fmi3/fmi3TerminalsAndIcons.xsd",
    }
    if version == 2:
        del schemas["terminalsAndIcons/terminalsAndIcons.xml"]
    with zipfile.ZipFile(packed) as opened:
        others = {"extra/org.fmi-standard.fmi-ls-ref/fmi-ls-manifest.xml"}  # its schema is that of fmi-ls-ref
        assert {name for name in opened.namelist() if name.endswith(".xml")} == schemas.keys() | others
        for name, schema in schemas.items():
            etree.XMLSchema(file=str(SCHEMAS / schema)).assertValid(etree.fromstring(opened.read(name)))


def test_terminals_and_icons_are_of_fmi3(fmus: dict[str, Path]) -> None:
    """An FMI 2 checker takes the folder of FMI 3 for a fatal error; FMI 2 has model.png."""
    for name, packed in fmus.items():
        with zipfile.ZipFile(packed) as opened:
            there = any(entry.startswith("terminalsAndIcons/") for entry in opened.namelist())
            assert there == name.endswith("fmi3"), name
            assert opened.read("model.png").startswith(b"\x89PNG"), name


def test_terminals_name_variables_and_pictures_that_exist(fmi3_fmu: Path) -> None:
    path, description = fmi3_fmu, read_model_description(str(fmi3_fmu), validate=False)
    causalities = {v.name: v.causality for v in description.modelVariables}
    terminals = etree.fromstring(content(path, "terminalsAndIcons/terminalsAndIcons.xml")).findall("Terminals/Terminal")
    assert len(terminals) == 2
    for terminal in terminals:
        members = terminal.findall("TerminalMemberVariable")
        assert len({m.get("memberName") for m in members}) == len(members) > 0
        assert all(causalities[m.get("variableName")] in ("input", "output") for m in members)
        base = terminal.find("TerminalGraphicalRepresentation").get("iconBaseName")
        assert content(path, f"terminalsAndIcons/{base}.png").startswith(b"\x89PNG")
    for picture in ("terminalsAndIcons/icon.png", "model.png", "documentation/diagram.png"):
        assert content(path, picture).startswith(b"\x89PNG")
    for drawing in ("terminalsAndIcons/icon.svg", "documentation/diagram.svg"):
        assert etree.fromstring(content(path, drawing)).tag.endswith("svg")


def test_reference_results_come_out_of_the_fmu(path: Path) -> None:
    table = np.genfromtxt(io.BytesIO(content(path, "extra/org.fmi-standard.fmi-ls-ref/EvatContact_ref.csv")), delimiter=",", names=True)
    columns = list(table.dtype.names or ())[1:]
    result = simulate_fmu(str(path), fmi_type="CoSimulation", output=columns, stop_time=1e-3, step_size=1e-6, output_interval=1e-6)
    assert len(result) == len(table) == 1001
    for name in columns:
        scale = np.max(np.abs(table[name]))
        assert scale > 0, name
        assert np.max(np.abs(result[name] - table[name])) <= 1e-8 * scale, name  # the file has 9 digits


def test_manifest_has_the_checksums_of_its_files(path: Path) -> None:
    folder = "extra/org.fmi-standard.fmi-ls-ref"
    manifest = etree.fromstring(content(path, f"{folder}/fmi-ls-manifest.xml"))
    assert manifest.get("{http://fmi-standard.org/fmi-ls-manifest}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    related = manifest.findall("Related")
    assert {r.get("source") for r in related} == {"EvatContact_ref.csv", "EvatContact_ref.opt"}
    for one in related:
        assert one.get("checksum") == hashlib.sha3_256(content(path, f"{folder}/{one.get('source')}")).hexdigest()


@ONE
@pytest.mark.usefixtures("unoptimised")
def test_sources_compile_as_they_are_listed(version: int, path: Path, tmp_path: Path) -> None:
    folder = Path(extract(str(path), unzipdir=str(tmp_path / "fmu")))
    configuration = read_build_description(str(folder))[0]
    files = configuration.sourceFileSets[0].sourceFiles
    if version == 2:
        assert read_model_description(str(folder)).buildConfigurations[0].sourceFileSets[0].sourceFiles == files
    assert not list(folder.rglob("fmi[23]*.h"))  # the importer's own headers count
    sources = [folder / "sources" / name for name in files]
    binary = compile_library(sources, tmp_path / f"Again{host_target().extension}", host_target(), include=[fmi_headers()])
    get_version = getattr(ctypes.CDLL(str(binary)), f"fmi{version}GetVersion")
    get_version.restype = ctypes.c_char_p
    assert get_version().startswith(f"{version}.0".encode())


class Links(HTMLParser):
    """Anchors and references of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.links: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id" and value:
                self.anchors.add(value)
            if name == "href" and value and tag == "a":
                self.links.add(value)


def test_documentation_tells_all_and_links_nowhere_else(path: Path) -> None:
    page = content(path, "documentation/index.html").decode()
    text = re.sub(r"&#?\w+;", lambda m: {"&lt;": "<", "&gt;": ">", "&amp;": "&", "&#39;": "'", "&#34;": '"'}.get(m[0], m[0]), page)
    for law in kernel.laws():
        assert law.equation in text, law.name
    for effect in kernel.effects():
        assert effect.equation in text, effect.name
    links = Links()
    links.feed(page)
    assert {v.name for v in kernel.variables()} <= links.anchors
    with zipfile.ZipFile(path) as opened:
        files = {f"documentation/{link}" for link in links.links if not link.startswith("#")}
        assert files <= set(opened.namelist())
    assert {link[1:] for link in links.links if link.startswith("#")} <= links.anchors
    assert "<script" not in page


def test_licence_and_dependencies_are_there(path: Path) -> None:
    licence = content(path, "documentation/licenses/license.txt").decode()
    assert licence.startswith("MIT License")
    assert read_model_description(str(path)).copyright in licence
    assert content(path, "documentation/externalDependencies.txt") == b"none\n"


def test_no_real_output_is_said_to_stand_still_between_events(description: ModelDescription) -> None:
    """Where no window is open a mean is the present value, which moves in continuous time, and a tool may read what is discrete at events
    only."""
    assert {v.variability for v in description.modelVariables if v.type in ("Real", "Float64") and v.causality == "output"} == {
        "continuous"
    }


@pytest.mark.parametrize("version", [2, 3])
def test_a_rise_of_temperature_has_no_offset(version: int, fmus: dict[str, Path]) -> None:
    """A tool that shows kelvins as degrees Celsius takes 273.15 off what is no difference."""
    root = etree.fromstring(content(fmus[f"tool_heat-fmi{version}"], "modelDescription.xml"))
    for name, relative in (("flash_temperature", "true"), ("contact_temperature", None)):
        (variable,) = root.xpath(f"//ModelVariables/*[@name='{name}']")
        said = variable[0] if version == 2 else variable
        (kind,) = root.xpath(f"//TypeDefinitions/*[@name='{said.get('declaredType')}']")
        assert said.get("relativeQuantity") == relative
        assert (kind[0] if version == 2 else kind).get("relativeQuantity") == relative
