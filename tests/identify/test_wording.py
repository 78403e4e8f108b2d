"""Does a sentence about an identification list all names, and is a standard error told in the unit of its estimate?"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from evat.identification.report.summary import _joined
from evat.identification.result import error_text
from evat.model import Variable


def test_names_are_joined_as_in_a_sentence() -> None:
    assert _joined([]) == ""
    assert _joined(["a"]) == "a"
    assert _joined(["a", "b"]) == "a and b"
    assert _joined(["a", "b", "c", "d"]) == "a, b, c and d"


def test_a_standard_error_is_told_in_the_unit_of_its_estimate() -> None:
    """Of a temperature a difference: 2 K are 2 degC, not 275."""

    def told(sd: float, unit: str, display_unit: str = "") -> str:
        variable = Variable("p", unit, 1.0, -1e9, 1e9, "of a test", "toy", display_unit=display_unit)
        one: Any = SimpleNamespace(sd=sd, variable=variable)
        return error_text(one)

    assert told(2.5e-6, "m", "um") == "2.5 um"
    assert told(2.0, "K", "degC") == "2 degC"
    assert told(0.25, "1") == "0.25"
    assert told(1e301, "m", "um") == told(float("nan"), "m") == "unbounded"
