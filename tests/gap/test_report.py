"""Does the report say what diagnosis.json says, to a person, alone on a screen or on paper, and keep text text?"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import check_layout
from diagnosed import EFFECT, diagnosed
from evat.experiment import Experiment
from evat.gap import diagnose_with
from evat.gap.answer import Diagnosis
from evat.gap.report import headline, write_diagnosis
from evat.gap.report.html_report import page
from evat.gap.report.parts import TITLES, parts
from evat.gap.report.pictures.series import POINTS, Series, extremes, stretch
from evat.gap.report.words import percent
from evat.gap.search.compare import Comparison
from evat.units import base_unit
from hypothesis import given, settings
from hypothesis import strategies as st
from lxml import etree, html
from toy import Toy, measured

EVIL = "</script><script>alert(1)</script><img src=x onerror=alert(2)> {{ 7*7 }} $x_2$ <b>&amp;"


def _page(answer: Diagnosis, comparison: Comparison, to: Path) -> str:
    write_diagnosis(answer, comparison, to)
    return (to / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory) -> str:
    return _page(*diagnosed(), tmp_path_factory.mktemp("report") / "out")


def test_the_page_fits_screen_phone_and_paper_and_its_pictures_show(text: str, tmp_path: Path) -> None:
    (tmp_path / "report.html").write_text(text, encoding="utf-8")
    check_layout(tmp_path / "report.html", plots=2)


def _evil(comparison: Comparison) -> Comparison:
    """The same with markup wherever a user's words go."""
    old = comparison.prediction.experiment
    trials = tuple(replace(trial, file=f"{EVIL}{trial.file}", condition=f"{EVIL}{trial.condition}") for trial in old.trials)
    new: Experiment = replace(old, title=EVIL, intended_use=EVIL, trials=trials, nominal=replace(old.nominal, parameters=EVIL))
    prediction, whitening = comparison.prediction, comparison.whitening
    made = object.__new__(type(prediction))
    made.__dict__.update(prediction.__dict__, experiment=new)
    made.segments = tuple(replace(segment, condition=f"{EVIL}{segment.condition}") for segment in prediction.segments)
    white = object.__new__(type(whitening))
    white.__dict__.update(whitening.__dict__, prediction=made)
    white.groups = tuple(replace(group, condition=f"{EVIL}{group.condition}") for group in whitening.groups)
    return replace(comparison, prediction=made, whitening=white)


def test_markup_in_names_stays_text(text: str, tmp_path: Path) -> None:
    """As many scripts and images as in the harmless report, the title letter for letter, and no event handler anywhere."""
    answer, comparison = diagnosed()
    closure = replace(answer.closure, held_out_conditions=tuple(f"{EVIL}{name}" for name in answer.closure.held_out_conditions))
    evil = _page(replace(answer, closure=closure, cannot_tell=(EVIL,), made_by={"version": EVIL}), _evil(comparison), tmp_path / "out")
    page, harmless = html.fromstring(evil), html.fromstring(text)
    assert page.findtext(".//h1") == EVIL
    for tag in ("script", "img", "b", "style"):
        assert len(list(page.iter(tag))) == len(list(harmless.iter(tag))), tag
    assert not any(name.startswith("on") for element in page.iter() for name in element.attrib)
    assert "49" not in page.findtext(".//h1")
    scripts = list(page.iter("script"))[1:]
    assert all("<" not in (script.text or "").replace("<\\/", "") for script in scripts if "Plotly.newPlot" in (script.text or ""))
    text_of_scripts = "".join(script.text or "" for script in scripts)
    assert "&lt;img" in text_of_scripts.replace("\\u0026", "&")  # plotly reads its texts as markup, so they are escaped once more


def test_it_stands_alone(text: str) -> None:
    """Plotly's script once, inline; no element that loads anything, and a policy that forbids it."""
    page = html.fromstring(text)
    assert text.count("plotly.js v") == 1
    assert not [element.tag for element in page.iter("link", "iframe", "object", "embed", "video", "base")]
    assert all(script.get("src") is None for script in page.iter("script"))
    assert all(image.get("src").startswith("data:image/svg+xml;base64,") for image in page.iter("img"))
    policy = page.find(".//meta[@http-equiv='Content-Security-Policy']").get("content")
    assert "default-src 'none'" in policy
    assert "http" not in policy
    assert len(text) < 8e6


def test_paper_has_every_picture(text: str) -> None:
    """As many as the screen, each a well-formed SVG that is shown in print and hidden on the screen."""
    page = html.fromstring(text)
    screen, paper = page.xpath("//div[@class='screen']"), page.xpath("//img[@class='paper']")
    assert len(screen) == len(paper) >= 3
    for image in paper:
        etree.fromstring(base64.b64decode(image.get("src").partition(",")[2]))
    assert re.search(r"@media print \{.*?\.screen \{ display: none; \}", text, re.DOTALL)


def _numbers(entry: Any) -> Iterator[float]:
    if isinstance(entry, dict):
        for part in entry.values():
            yield from _numbers(part)
    elif isinstance(entry, list):
        for part in entry:
            yield from _numbers(part)
    elif isinstance(entry, (int, float)):
        yield float(entry)


def test_the_top_says_all_that_matters() -> None:
    """One status; the physics of the effect in the model's own words; the share with its interval; one thing to do. A refusal says why."""
    answer, comparison = diagnosed()
    said = headline(answer, comparison)
    (effect,) = (each for each in comparison.prediction.model.effects if each.name == EFFECT)
    assert f"{EFFECT}: {effect.physics} (" in said.sentence
    assert "switch" not in said.sentence
    low, high = (percent(end) for end in answer.closure.interval)
    assert said.share == percent(answer.closure.closed_share)
    assert f"90 % interval {low} to {high}" in said.share_of
    assert "corrected.ssv" in said.next
    assert (said.first, said.tone) == ((), "good")
    turned = replace(comparison, audit=replace(comparison.audit, refused=("force: measured runs against the model",)))
    refused = headline(replace(answer, verdict="cannot_tell", effects=()), turned)
    assert (refused.status, refused.tone) == ("cannot tell", "bad")
    assert refused.reasons == turned.audit.refused
    assert not refused.share


def test_bar_and_sentence_agree_where_recalibration_could_stand_in() -> None:
    """Recalibrated values that take up nearly all that the effect explains leave the bar as it is: it goes by the model that is named."""
    answer, comparison = diagnosed()
    chosen = comparison.models[answer.judgement.chosen]
    (own,) = parts(comparison, chosen).values()
    assert own.share("effect") > 0.7
    absorbed = replace(comparison, recalibrated=replace(comparison.recalibrated, predicted=chosen.predicted))
    (same,) = parts(absorbed, chosen).values()
    assert same.share("effect") == pytest.approx(own.share("effect"))


def test_its_numbers_are_those_of_the_json(text: str) -> None:
    """Every number of these parts of diagnosis.json stands in the report, and none stands there that is not in it."""
    answer, _ = diagnosed()
    document = json.loads(answer.json())
    printed = {float(each.get("value")) for each in html.fromstring(text).iter("data") if each.get("value")}
    told = {
        part: set(_numbers(document[part]))
        for part in ("effects", "candidates", "novelty", "recalibration", "setup", "gap", "next_experiment")
    }
    told["gates"] = {float(gate[key]) for gate in document["gates"] for key in ("value", "threshold") if gate[key] is not None}
    told["where"] = set(_numbers(document["where"]["channels"])) | set(_numbers(document["where"]["regions"]))
    for part, numbers in told.items():
        assert numbers <= printed, part
    assert printed <= set().union(*told.values())


def test_a_number_on_the_page_is_the_number_behind_it(text: str) -> None:
    """What is printed rounds to what the JSON has: within half of its last digit, in its unit, as a number or in per cent."""
    checked = 0
    for each in html.fromstring(text).iter("data"):
        printed = re.fullmatch(r"(-?[\d.]+(?:e[+-]?\d+)?)( %)?", (each.text or "").strip())
        if printed is None:
            continue  # a bound in another unit, a share below what is printed
        value = float(each.get("value")) * (100 if printed[2] else 1) / float(base_unit(each.get("data-unit") or "1").factor)
        assert float(printed[1]) == pytest.approx(value, rel=0.06)
        checked += 1
    assert checked > 20


def test_more_than_all_of_the_gap_is_printed_as_it_is(tmp_path: Path) -> None:
    """115 % in diagnosis.json was "100 % (100 % to 100 %)" on the page; above all of it, the page says what that means."""
    answer, comparison = diagnosed()
    closure = replace(answer.closure, closed_share=1.153, interval=(1.137, 1.167))
    body = html.fromstring(_page(replace(answer, closure=closure), comparison, tmp_path / "out")).text_content()
    assert "The effects close 115 % (90 % interval 114 % to 117 %; above 100 % less is left than the noise was estimated at" in body
    assert "115 % of what recalibration leaves above the noise is closed by the fit" in " ".join(body.split())


def test_what_was_recorded_in_millimetres_is_shown_in_them(tmp_path: Path) -> None:
    """Speeds in the unit of the files, also those that are no signal; on the axes, in the table and where the gap lies."""
    answer, comparison = diagnosed()
    read = comparison.prediction.experiment
    signals = {**read.signals, "slip_velocity": replace(read.signals["slip_velocity"], unit="mm/s")}
    signals["friction_force"] = replace(read.signals["friction_force"], unit="kN")
    prediction = copy(comparison.prediction)
    prediction.experiment = replace(read, signals=signals)
    comparison = replace(comparison, prediction=prediction)
    page = _page(answer, comparison, tmp_path / "out")
    assert r"slip velocity [mm\u002fs]" in page
    assert r"friction force [kN]" in page
    assert r"[m\u002fs]" not in page
    rows = {row[0].text_content(): row for row in html.fromstring(page).iter("tr")}
    assert float(rows["v_s [mm/s]"][1].text_content()) == pytest.approx(1e3 * float(read.nominal.values["v_s"]), rel=1e-3)
    series = Series(comparison, None)
    assert np.ptp(series.record(0).signals["slip_velocity"]) > 10.0  # mm/s
    assert np.ptp(series.record(0).lines["measured"]) < 0.1  # kN
    assert float(rows["friction force [kN]"][2].text_content()) < 0.01  # the last such row has values alone


def test_the_parts_of_the_gap_add_up(text: str) -> None:
    """To the mean square of measured less nominal, as it is; the noise is what was put in, and the effect most of the rest."""
    answer, comparison = diagnosed()
    (own,) = parts(comparison, comparison.models[answer.judgement.chosen]).values()
    left = comparison.prediction.measured - comparison.nominal.predicted
    assert own.total == pytest.approx(float(np.mean(left**2)), rel=0.02)  # noise and repeatability are estimates
    assert sum(own.share(name) for name in TITLES) == pytest.approx(1.0)
    assert 0.7 < own.rms("noise") / 0.05 < 1.4
    assert own.share("effect") > 0.4  # a zero of the set-up may stand in for part of an asymmetry
    assert own.share("effect") + own.share("mistuning") + own.share("set_up") > 0.95
    assert 0 <= own.share("numerical") < 0.01
    assert own.share("unexplained") < 0.01
    for name in TITLES:
        assert min(getattr(own, name), 0.0) == 0.0
    assert f"{100 * own.share('effect'):.0f} %" in text


def test_a_zero_of_the_set_up_is_no_mistuning(tmp_path: Path) -> None:
    """It was: 64 % "mis-tuning" where no value had moved. It stands in the page with value and unit, and is in no closure by values."""
    answer, comparison = diagnose_with(measured(noise=0.03, extra=np.full(400, 0.08)), Toy())
    (own,) = parts(comparison, comparison.recalibrated).values()
    assert own.share("mistuning") < 0.01
    assert own.share("set_up") > 0.7
    zero, sd, unit = answer.recalibration.setup["F"]["zero"]
    assert (pytest.approx(0.08, abs=4 * sd), unit) == (zero, "N")
    assert [(error.channel, error.kind) for error in answer.recalibration.notable] == [("F", "zero")]
    alone, fitted = answer.closure.values_alone, answer.closure.rms["F"]
    assert abs(alone.closed_share) < 0.01
    assert alone.rms["F"]["corrected"] == pytest.approx(alone.rms["F"]["nominal"], rel=0.01)
    assert fitted["corrected"] < 1.1 * fitted["noise_floor"]
    (recalibrated,) = diagnose_with(measured(noise=0.03), Toy())[0].closure.values_alone.rms.values()
    assert recalibrated["corrected"] < 0.5 * alone.rms["F"]["corrected"]


def test_the_page_tells_the_set_up_apart(text: str) -> None:
    body = " ".join(html.fromstring(text).text_content().split())
    assert "What the set-up takes up" in body
    assert "None of them is in corrected.ssv" in body
    assert "By itself corrected.ssv closes" in body
    assert "and so is corrected.ssv" not in body


def test_where_no_effect_is_named_the_page_does_not_contradict_itself() -> None:
    """ "The best candidate leaves 100 % unexplained" beside a table with 16 %; an experiment beside the next step "nothing"; "none"."""
    answer, comparison = diagnose_with(measured(), Toy())
    body = " ".join(html.fromstring(page(answer, comparison, None, "it was not asked for")).text_content().split())
    assert answer.verdict == "no_gap"
    assert "best candidate" not in body
    assert "beside recalibrated values 0 % of what the nominal values leave stays unexplained" in body
    assert "There are no two likely models that another condition of this kind would have to tell apart." in body
    assert "To tell no effect from" not in body


def test_why_no_condition_is_held_out_is_one_reason(tmp_path: Path) -> None:
    """The top said that the others do not determine the values, and the page that there were too few conditions."""
    answer, comparison = diagnosed()
    nan = float("nan")
    closure = replace(
        answer.closure,
        closed_share=nan,
        interval=(nan, nan),
        held_out_conditions=(),
        closed_share_where_fitted=(0.7, (0.6, 0.8)),
        unforeseen=("slow",),
    )
    body = " ".join(html.fromstring(_page(replace(answer, closure=closure), comparison, tmp_path / "out")).text_content().split())
    assert body.count("without slow the others do not determine the values") == 2
    assert "too few conditions" not in body


def test_it_says_what_the_verdict_is_and_where(text: str) -> None:
    page = html.fromstring(text)
    assert EFFECT in page.find(".//p[@class='verdict']").text
    body = page.text_content()
    assert "normal_load was not recorded" in body
    for word in ("What could not be tested", "The next experiment", "autoregression", "hash of no file", "was not run"):
        assert word in body


def test_every_condition_can_be_chosen_and_no_line_is_long(text: str) -> None:
    answer, comparison = diagnosed()
    for condition in comparison.prediction.experiment.conditions:
        assert text.count(f'"label":"{condition}"') == 2
    series = Series(comparison, comparison.models[answer.judgement.chosen].predicted)
    assert len(series.recorded("friction_force")) == 4


@given(st.integers(1, 9000), st.integers(0, 5))
@settings(max_examples=25, deadline=None)
def test_thinning_keeps_the_extremes(size: int, seed: int) -> None:
    column = np.random.default_rng(seed).standard_normal(size)
    kept = extremes(column)
    assert kept.size <= POINTS
    assert np.all(np.diff(kept) > 0)
    assert column[kept].max() == column.max()
    assert column[kept].min() == column.min()
    part = column[stretch(column)]
    assert part.size == min(size, POINTS)


def test_the_stretch_is_where_the_gap_is() -> None:
    gap = np.zeros(10_000)
    gap[7000:7100] = 1.0
    part = stretch(gap)
    assert part.start <= 7000
    assert part.stop >= 7100
