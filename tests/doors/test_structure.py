"""Is the model structure that was kept from an earlier build the one that the kernel would tell again?"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from evat import fmu
from evat.fmu.fmu_facts import Version
from evat.fmu.structure import model_structure as structure
from evat.fmu.structure import probe
from evat.fmu.structure import random_values as draw
from evat.fmu.structure import structure_cache as kept
from evat.fmu.structure.model_structure import Structure
from evat.model import Effect
from evat.native import kernel
from evat.native.compile import CONTACT, host_target


@pytest.fixture(scope="module")
def kernel_structure() -> Structure:
    """What was kept beside this library when its FMUs were built, so that it need not be found again for each test."""
    return structure.model_structure()


class Asked:
    """The kernel's structure, counting how often it was asked for."""

    def __init__(self, answer: Structure) -> None:
        self.answer = answer
        self.count = 0

    def __call__(self) -> Structure:
        self.count += 1
        return self.answer

    def again(self) -> Structure:
        """As a new process would."""
        structure.model_structure.cache_clear()
        return structure.model_structure()


@pytest.fixture
def place(tmp_path: Path) -> Path:
    return tmp_path / "kept.json"


@pytest.fixture
def asked(kernel_structure: Structure, place: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Asked]:
    asked = Asked(kernel_structure)
    monkeypatch.setattr(structure, "find_structure", asked)
    monkeypatch.setattr(structure, "place_of", lambda library: place)
    structure.model_structure.cache_clear()
    yield asked
    structure.model_structure.cache_clear()


def test_the_kernel_is_asked_once(asked: Asked, kernel_structure: Structure, place: Path) -> None:
    assert asked.again() == kernel_structure
    assert asked.again() == kernel_structure
    assert asked.count == 1
    assert [path.name for path in place.parent.iterdir()] == [place.name]  # no scratch file stays


@pytest.mark.campaign  # a minute; that of a fresh checkout is asked for where its FMUs are built
def test_asking_again_gives_what_was_kept(kernel_structure: Structure) -> None:
    assert structure.find_structure() == kernel_structure


def change_a_name(text: str) -> str:
    return text.replace('"slip_velocity"', '"proxy_speed"', 1)


def change_the_key(text: str) -> str:
    return json.dumps({**json.loads(text), "key": "0" * 64})


@pytest.mark.parametrize(
    "spoil",
    [
        lambda text: "",
        lambda text: text[: len(text) // 2],
        lambda text: "[" * 100_000,
        lambda text: "[]",
        lambda text: "{}",
        lambda text: "null",
        lambda text: "\x00\xff",
        change_a_name,
        change_the_key,
    ],
)
def test_a_spoilt_file_is_ignored_and_written_anew(spoil: object, asked: Asked, kernel_structure: Structure, place: Path) -> None:
    asked.again()
    good = place.read_bytes()
    spoilt = spoil(good.decode())  # type: ignore[operator]
    assert spoilt.encode() != good
    place.write_text(spoilt, encoding="utf-8")
    assert asked.again() == kernel_structure
    assert asked.count == 2
    assert place.read_bytes() == good


def test_a_folder_that_cannot_be_written_keeps_nothing_and_harms_nothing(
    asked: Asked, kernel_structure: Structure, place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (place.parent / "file").write_text("no folder", encoding="utf-8")
    monkeypatch.setattr(structure, "place_of", lambda library: place.parent / "file" / "kept.json")
    assert asked.again() == kernel_structure
    assert asked.again() == kernel_structure
    assert asked.count == 2


def test_another_library_or_another_way_of_asking_has_another_key(tmp_path: Path) -> None:
    library, module = tmp_path / "a.so", tmp_path / "a.py"
    library.write_bytes(b"one")
    module.write_bytes(b"x")
    first = kept.key_of(library, [module])
    assert kept.key_of(library, [module]) == first
    library.write_bytes(b"two")
    second = kept.key_of(library, [module])
    library.write_bytes(b"one")
    module.write_bytes(b"y")
    assert len({first, second, kept.key_of(library, [module])}) == 3
    kept.keep(tmp_path / "kept.json", first, {"outputs": []})
    assert kept.recall(tmp_path / "kept.json", first) == {"outputs": []}
    assert kept.recall(tmp_path / "kept.json", second) is None


@pytest.mark.usefixtures("unoptimised")
def test_an_fmu_from_the_file_has_the_same_bytes(asked: Asked, tmp_path: Path) -> None:
    built, binaries = [], dict[tuple[Version, str, str], bytes]()  # compiled once
    for number in range(2):
        structure.model_structure.cache_clear()
        made = fmu.build_sharing(3, tmp_path / f"{number}.fmu", [host_target().fmi3_folder], fmu.silent, CONTACT, binaries)
        built.append(made.read_bytes())
    assert asked.count == 1  # the second is from the file
    assert built[0] == built[1]


def test_rivals_are_never_on_together(monkeypatch: pytest.MonkeyPatch) -> None:
    effects = tuple(
        Effect(name, "", "", "", rivals=rivals) for name, rivals in (("a", ("b",)), ("b", ()), ("c", ("d", "a")), ("d", ()), ("e", ()))
    )
    monkeypatch.setattr(kernel, "effects", lambda: effects)
    luck = random.Random(1)
    drawn = [frozenset(probe.choose_effects(luck, 0.5)) for _ in range(2000)]
    for pair in ({"a", "b"}, {"c", "d"}, {"a", "c"}):
        assert not [on for on in drawn if pair <= on]
    # all that may be on together are: e or not, and of a, b, c, d none, one, or one of (a d), (b c), (b d)
    assert len(set(drawn)) == 2 * (1 + 4 + 3)


def test_draws_lie_within_the_bounds_and_differ() -> None:
    luck = random.Random(2)
    for variable in kernel.variables():
        if variable.causality in ("parameter", "input"):
            values = [draw.draw(variable, luck) for _ in range(300)]
            assert variable.min <= min(values) < max(values) <= variable.max, variable.name


def test_a_neighbour_has_few_other_values_and_no_rivals() -> None:
    one = probe.Probe()
    one.fruitful = [one.choose()]
    effects = {effect.name: effect for effect in kernel.effects()}
    differ = []
    for _ in range(300):
        near = one.choose()
        on = {name for name in effects if near[name]}
        assert not any(on & set(effects[name].rivals) for name in on)
        assert set(near) == {variable.name for variable in one.fixed}
        differ.append(sum(near[name] != one.fruitful[0][name] for name in near))
    assert sum(count <= 8 for count in differ) > 100  # half of them are neighbours
    assert sum(count > 8 for count in differ) > 100


@pytest.mark.parametrize("seed", range(3))
def test_what_is_taken_to_be_told_at_rest_would_change_nothing(seed: int) -> None:
    """Any part of the pairs that are not looked at any more may be seen after all, and each unknown follows the same at the start."""
    one, luck = probe.Probe(), np.random.default_rng(seed)
    one.initial |= luck.random(one.initial.shape) < 0.02 * (luck.random((len(one.unknowns), 1)) < 0.5)
    told = one.told_at_rest
    late = sorted({*one.outputs, *one.rates}, key=lambda variable: variable.index)
    before = [one.initial_knowns(unknown) for unknown in late]
    assert np.count_nonzero(told & ~one.initial) > 200
    assert np.any(~told)
    one.initial |= told & (luck.random(told.shape) < 0.5)
    assert [one.initial_knowns(unknown) for unknown in late] == before
    assert np.array_equal(one.told_at_rest, told)
    one.initial |= ~told
    assert [one.initial_knowns(unknown) for unknown in late] != before
