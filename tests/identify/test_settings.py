"""Do the settings say all that an answer depends on, can they not be changed under way, and is each of them explained?"""

from __future__ import annotations

import inspect
import re
from dataclasses import FrozenInstanceError, fields

import pytest
from evat.identification import Execution, Settings, identify
from known_rigs import GUESS, MODEL, TO_AND_FRO, experiment, trial


@pytest.mark.parametrize("kind", [Settings, Execution])
def test_every_field_is_explained_and_none_can_be_changed(kind: type[Settings] | type[Execution]) -> None:
    explained = re.findall(r"^(\w+) : ", inspect.cleandoc(kind.__doc__ or ""), flags=re.MULTILINE)
    assert explained == [field.name for field in fields(kind)]
    with pytest.raises(FrozenInstanceError):
        setattr(kind(), explained[0], None)


def test_the_answer_says_its_settings_and_not_how_it_was_carried_out() -> None:
    settings = Settings(search="none", whiten=False, profiles=False, seed=7, values={"sigma1": 0.0})
    said: list[str] = []
    answers = [
        identify(experiment(trial(TO_AND_FRO), nominal=GUESS), MODEL, ("F_C", "sigma0"), settings, execution=execution)
        for execution in (Execution(), Execution(progress=lambda doing, share: said.append(doing)))
    ]
    assert said
    made_by = answers[0].made_by
    assert (made_by["search"], made_by["whiten"], made_by["seed"]) == ("none", False, 7)
    assert answers[0].values["sigma1"] == 0.0
    assert made_by == answers[1].made_by
    assert [estimate.value for estimate in answers[0].estimates] == [estimate.value for estimate in answers[1].estimates]
