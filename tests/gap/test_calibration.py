"""Are the cases of a campaign what they claim, does it go on where it stopped, and do its constants make probabilities truer?"""

from __future__ import annotations

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from evat.commands.main import app
from evat.constants import CONSTANTS
from evat.gap.search.candidates import of_one_family
from evat.gap.verdict import constants as kept_constants
from evat.gap.verdict.calibrate import CalibrationCase, fit_constants, probability, with_unknown
from evat.gap.verdict.constants import Constants, store, stored
from evat.gap.verdict.features import Features
from evat.gap.verdict.judgement import MISTUNED, NO_GAP, UNKNOWN, judge
from evat.inference.hypothesis import Hypothesis
from evat.model import EvatError
from evat.models.contact import ContactModel
from evat.studies.calibration import campaign as campaigns
from evat.studies.calibration.campaign import KINDS, campaign, draw_case, numbers
from typer.testing import CliRunner


def _features(
    gap: float,
    gains: dict[str, tuple[float, float]],
    *,
    exact: float = 0.0,
    before: float | None = None,
    foreign: float = 0.0,
    unsure: float = 0.0,
) -> Features:
    """gap : structural square over that of the noise; unsure : its sd over the same; gains : effects by + -> log evidence, share left."""
    sets = {Hypothesis(tuple(name.split("+"))): value for name, value in gains.items()}
    floor = 1e-4
    return Features(
        nominal={"F": (before if before is not None else gap) * floor},
        recalibrated={"F": gap * floor},
        floor={"F": floor},
        unsure={"F": unsure * floor},
        irregular={"F": foreign * floor},
        irregular_share={"F": foreign},
        exact=exact,
        gain={on: gain for on, (gain, _) in sets.items()},
        left={on: left for on, (_, left) in sets.items()},
    )


@pytest.mark.parametrize(
    ("seen", "verdict", "chosen"),
    [
        (_features(0.01, {"a": (-2, 1.0)}, exact=15), NO_GAP, ()),
        (_features(0.01, {"a": (-2, 1.0)}, exact=-500, before=30), MISTUNED, ()),
        (_features(30, {"a": (300, 0.01), "b": (40, 0.8)}, exact=-50), "effect", ("a",)),
        (_features(12, {"a": (9, 0.01)}, exact=-500, before=30), "effect", ("a",)),
        (_features(12, {"a": (9, 0.01)}, exact=-500, before=30, unsure=30), MISTUNED, ()),
        (_features(30, {"a": (300, 0.01), "b": (299, 0.01)}, exact=-50), "ambiguous", ("a",)),
        (_features(30, {"a": (3, 0.97), "b": (1, 0.99)}, exact=-50), UNKNOWN, ()),
        (_features(30, {"a": (3, 0.4), "b": (1, 0.6)}, exact=-50), UNKNOWN, ()),
        (_features(30, {}, exact=-50), UNKNOWN, ()),
        (_features(0.01, {"a": (-2, 1.0)}, exact=15, foreign=0.9), UNKNOWN, ()),
        (_features(0.01, {"a": (-2, 1.0)}, exact=15, foreign=0.1), NO_GAP, ()),
        (_features(0.04, {"a": (200, 0.9)}, exact=-50), "effect", ("a",)),  # too small to look at, but evident
        (_features(0.04, {"a": (50, 0.55)}, exact=-50), NO_GAP, ()),  # a base law of another form feigns as much
        (_features(30, {"a": (300, 0.02), "a+b": (320, 0.02)}), "effect", ("a",)),  # nothing left for a second one
        (_features(30, {"a": (300, 0.3), "a+b": (500, 0.01)}), "effect", ("a", "b")),
    ],
)
def test_verdicts(seen: Features, verdict: str, chosen: tuple[str, ...]) -> None:
    said = judge(seen, Constants())
    assert (said.verdict, said.chosen) == (verdict, Hypothesis(chosen))
    assert math.isclose(sum(said.probabilities.values()) + said.unknown, 1.0, rel_tol=1e-9)


def test_a_chain_of_sensors_is_one_filter() -> None:
    """Where two filters do what one of another form does, it is the likelier of them that is named."""
    seen = _features(30, {"a": (300, 0.3), "a+b": (500, 0.01)})
    assert judge(seen, Constants()).chosen == Hypothesis(("a", "b"))
    assert judge(replace(seen, one_family={Hypothesis(("a", "b")): True}), Constants()).chosen == Hypothesis(("a",))
    model, delay = ContactModel(threads=1), "sensor_delay"
    pairs = {
        (delay, "sensor_lowpass"): True,
        (delay, "input_delay"): True,
        (delay, "sensor_gain"): False,
        ("backlash", "input_delay"): False,
    }
    assert {names: of_one_family(model, Hypothesis(names)) for names in pairs} == pairs
    assert not of_one_family(model, Hypothesis((delay,)))


def test_few_numbers_overstate_less() -> None:
    """What is wrong with the form of an effect has little to add up in: of a table of 30 means 16 of log evidence are what they say."""
    seen = _features(0.5, {"a": (16, 0.05), "b": (9, 0.2)}, exact=-3)
    assert judge(seen, Constants()).verdict != "effect"
    said = judge(replace(seen, numbers=30), Constants())
    assert (said.verdict, said.chosen) == ("effect", Hypothesis(("a",)))
    by_chance = _features(0.5, {"a": (5, 0.05), "b": (4, 0.2)}, exact=-3)
    assert judge(replace(by_chance, numbers=30), Constants()).verdict not in ("effect", "ambiguous")


def test_a_case_depends_on_its_number_alone() -> None:
    first, again = draw_case(2), draw_case(2)
    assert first is not None
    assert again is not None
    assert first[1] == again[1]
    for one, other in zip(first[0].trials, again[0].trials, strict=True):
        assert one.file == other.file
        for name, column in one.outputs.items():
            assert np.array_equal(column, other.outputs[name])


@pytest.mark.parametrize("number", range(len(KINDS)))
def test_a_case_is_of_its_kind(number: int) -> None:
    drawn = draw_case(number)
    if drawn is None:
        pytest.skip("the effect that was drawn does nothing there")
    _, truth = drawn
    kind = KINDS[number]
    if kind == "pair":
        assert truth.count("+") == 1
    elif kind != "single":
        assert truth == kind
    else:
        assert truth not in KINDS


def test_a_case_comes_back_from_its_line_with_every_feature() -> None:
    on = Hypothesis(("a",))
    seen = replace(
        _features(30, {"a": (300, 0.01)}, foreign=0.2, unsure=1.0),
        held_out={on: 0.1},
        doubts={on: ("why",)},
        shift=2.0,
        shifts={on: 1.5},
        numbers=40,
        one_family={on: True},
        general={on: 1},
    )
    assert all(getattr(seen, each.name) for each in fields(Features) if each.name != "exact")
    assert CalibrationCase.read(CalibrationCase(seen, "a").line()).features == seen


def test_a_case_is_run_to_its_line() -> None:
    """As the campaign does; number 22 is done in some seconds."""
    entry = campaigns._entry(campaigns.run_case(22))
    assert entry is not None
    assert entry["number"] == 22
    drawn = draw_case(22)
    assert drawn is not None
    assert CalibrationCase.read(entry["case"]).truth == drawn[1]


def test_a_campaign_goes_on_where_it_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    line = CalibrationCase(_features(30, {"a": (300, 0.01)}), "a").line()
    path, asked = tmp_path / "state.jsonl", list[int]()

    class Pool:
        def __init__(self, workers: int) -> None:
            pass

        def __enter__(self) -> Pool:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def map(self, job: object, numbers: list[int]) -> list[str]:
            asked.extend(numbers)
            return [campaigns._line({"number": number, "case": line} if number % 2 else {"number": number}) for number in numbers]

    monkeypatch.setattr(campaigns, "process_pool", Pool)
    assert len(list(campaign(path, 4, 1))) == 2
    with path.open("a") as file:
        file.write('{"number": 4, "ca')  # stopped while it wrote
    cases = list(campaign(path, 8, 1))
    assert asked == [0, 1, 2, 3, 4, 5, 6, 7]
    assert numbers(cases) == {"single": 4}
    assert cases[0].features == CalibrationCase.read(line).features


def test_a_case_that_is_damaged_or_of_another_kernel_or_table_is_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case that was kept was taken under another table of constants: log evidence of 132 where it is 109 by that."""
    line = CalibrationCase(_features(30, {"a": (300, 0.01)}), "a").line()
    path, asked = tmp_path / "state.jsonl", list[int]()

    def run(number: int) -> str:
        asked.append(number)
        return campaigns._line({"number": number, "case": line})

    monkeypatch.setattr(campaigns, "run_case", run)
    monkeypatch.setattr(campaigns, "process_pool", ThreadPoolExecutor)
    assert len(list(campaign(path, 5, 1))) == 5
    lines = path.read_bytes().splitlines()
    lines[1] = lines[1].replace(b"300", b"301")  # still JSON, and another case
    lines[2] = lines[2][:40]
    lines[3] = b'{"number": 3}'
    with monkeypatch.context() as elsewhere:
        elsewhere.setattr(campaigns, "kernel_digest", lambda: "another kernel")
        lines[4] = campaigns._line({"number": 4, "case": line}).encode()
    with CONSTANTS.replaced(law_shape_sd=2 * CONSTANTS.law_shape_sd):
        lines[0] = campaigns._line({"number": 0, "case": line}).encode()
        assert campaigns._entry(lines[0].decode()) is not None
    path.write_bytes(b"\n".join([*lines, b"\xff\xfe", b"[]", b""]))
    asked.clear()
    cases = list(campaign(path, 5, 1))
    assert sorted(asked) == [0, 1, 2, 3, 4]
    assert all(case.features == CalibrationCase.read(line).features for case in cases)
    asked.clear()
    assert len(list(campaign(path, 5, 1))) == 5
    assert asked == []


def _kept(path: Path, count: int) -> None:
    """A campaign of so many cases that were done before."""
    gains = {"a": (300.0, 0.01), "b": (20.0, 0.9)}
    lines = [CalibrationCase(_features(30, gains), "a" if n % 2 else UNKNOWN).line() for n in range(count)]
    path.write_text("".join(campaigns._line({"number": n, "case": line}) + "\n" for n, line in enumerate(lines)))


def test_calibrate_writes_its_constants_where_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "package.json"
    monkeypatch.setattr(kept_constants, "STORED", package)
    _kept(tmp_path / "state.jsonl", 6)
    asked = ["calibrate", "--cases", "6", "--workers", "1", "--state", str(tmp_path / "state.jsonl")]
    result = CliRunner().invoke(app, [*asked, "--out", str(tmp_path / "constants.json")])
    assert result.exit_code == 0, result.output
    monkeypatch.setattr(kept_constants, "STORED", tmp_path / "constants.json")
    constants, origin = stored()
    assert constants != Constants()
    assert "6" in origin
    assert not package.exists()


def test_constants_of_a_few_cases_are_not_kept_in_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "package.json"
    monkeypatch.setattr(kept_constants, "STORED", package)
    _kept(tmp_path / "state.jsonl", 20)
    asked = ["calibrate", "--store", "--workers", "1", "--state", str(tmp_path / "state.jsonl")]
    result = CliRunner().invoke(app, [*asked, "--cases", "6"])
    assert result.exit_code != 0
    assert not package.exists()
    assert CliRunner().invoke(app, [*asked, "--cases", "20"]).exit_code == 0
    assert package.exists()


def test_constants_of_a_campaign_are_truer_than_those_before_it() -> None:
    """A world in which evidence is worth a tenth of what the reasoned constants take it for."""
    draw, cases = np.random.default_rng(5), list[CalibrationCase]()
    for _ in range(60):
        a, b = draw.normal(size=2) * 60 + 300
        gains = {"a": (float(a), 0.05), "b": (float(b), 0.05)}
        cases.append(CalibrationCase(_features(30, gains), "a" if draw.random() < 1 / (1 + math.exp((b - a) / 150)) else "b"))
    before = np.mean([-math.log(probability(case, Constants())) for case in cases])
    constants, loss = fit_constants(cases)
    after = np.mean([-math.log(probability(case, constants)) for case in cases])
    assert after < 0.8 * before
    assert after <= loss < before
    assert constants.temperature > 1.5 * Constants().temperature


def test_an_effect_that_is_taken_out_is_unknown() -> None:
    cases = with_unknown(
        [
            CalibrationCase(_features(30, {"a": (300, 0.01), "a+b": (310, 0.01), "b": (20, 0.9)}), "a"),
            CalibrationCase(_features(1, {}), NO_GAP),
        ]
    )
    assert [case.truth for case in cases] == ["a", UNKNOWN, NO_GAP]
    assert list(cases[1].features.gain) == [Hypothesis(("b",))]
    assert judge(cases[1].features, Constants()).verdict == UNKNOWN


def test_constants_are_kept_with_how_they_were_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kept_constants, "STORED", tmp_path / "calibration.json")
    assert stored() == (Constants(), "reasoned")
    store(Constants(temperature=7.0), {"cases": {"single": 60}}, tmp_path / "calibration.json")
    constants, origin = stored()
    assert constants == Constants(temperature=7.0)
    assert "60" in origin


@pytest.mark.parametrize("damage", ["empty", "torn", "a digit", "no digest", "no JSON object"])
def test_constants_that_are_damaged_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str) -> None:
    """A disk that was full while they were kept, a bit that fell over: not half of them, and none that nobody has found."""
    path = tmp_path / "calibration.json"
    monkeypatch.setattr(kept_constants, "STORED", path)
    store(Constants(temperature=7.0), {"cases": {"single": 60}}, path)
    text = path.read_text()
    held = json.loads(text)
    held.pop("digest")
    path.write_text(
        {
            "empty": "",
            "torn": text[: len(text) // 2],
            "a digit": text.replace("7.0", "8.0"),
            "no digest": json.dumps(held),
            "no JSON object": "[]",
        }[damage]
    )
    with pytest.raises(EvatError, match=r"calibration.json: the constants of the diagnosis are damaged.*evat calibrate --store"):
        stored()


def test_a_benchmark_keeps_the_answers_that_are_there(tmp_path: Path) -> None:
    cases, to = tmp_path / "cases", tmp_path / "out"
    for name in ("one", "two"):
        (cases / name).mkdir(parents=True)
        (cases / name / "experiment.toml").write_text("format = 2\n")
    (to / "one").mkdir(parents=True)
    (to / "one" / "diagnosis.json").write_text('{"verdict": "kept"}')
    (to / "two").mkdir()
    (to / "two" / "diagnosis.json").write_text('{"verdict": "ke')  # cut off when the disk was full
    result = CliRunner().invoke(app, ["benchmark", str(cases), "--out", str(to), "--workers", "1"])
    assert result.exit_code == 0, result.output
    assert json.loads((to / "one" / "diagnosis.json").read_text()) == {"verdict": "kept"}
    assert json.loads((to / "two" / "diagnosis.json").read_text())["verdict"] == "error"


def test_a_benchmark_of_nothing_is_told(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["benchmark", str(tmp_path)])
    assert result.exit_code != 0
