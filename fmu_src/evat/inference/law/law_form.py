"""In which ways may measured forces differ from those of a law with all its parameters? In those in which published laws differ.

No law of friction and no model of a cut is exact. What laws differ in are columns that a motion tells without any of them; what the
parameters of the law that is there cannot do anyway is the form of it, known to be small, and free in every fit.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from evat.constants import CONSTANTS
from evat.inference.law.cut_form import cut_forms
from evat.inference.law.friction_form import friction_forms
from evat.inference.parameters import Parameter
from evat.inference.prediction import Linearised, Prediction
from evat.model import FloatArray


def with_law_forms(
    prediction: Prediction, slopes: FloatArray, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()
) -> Prediction:
    """The same with the forms that its law may have in the motions that were recorded or that the model makes, as linear parameters. As it
    is where neither is there.

    slopes : (N, p), what the parameters do already; values, on : of the model, whose bristles bend over some way.
    """
    forms = list[Linearised]()
    for table, at in (friction_forms(prediction, values or {}, on), cut_forms(prediction, values or {}, on)):
        forms += _linear_parameters(prediction, table, at, slopes, len(forms))
    return prediction.linearise((*prediction.linearised, *forms)) if forms else prediction


def _linear_parameters(
    prediction: Prediction, table: FloatArray, at: npt.NDArray[np.intp], slopes: FloatArray, before: int
) -> list[Linearised]:
    """Of columns (n, k) at some places (n,) of the long vector, what the slopes cannot do: those that do most first, each with the size
    that it may have; so many parameters are there before."""
    table = table[:, np.any(table, axis=0)]
    if not table.size:
        return []
    levels = np.ones(prediction.measured.size)
    for channel in prediction.channels:
        places = np.intersect1d(prediction.places(channel), at)
        levels[places] = np.sqrt(np.mean(prediction.measured[places] ** 2)) if places.size else 1.0
    level = levels[at]
    known = slopes[at] / level[:, None]
    known, _ = np.linalg.qr(known[:, np.any(known, axis=0)])
    own = table / np.sqrt(np.mean(table**2, axis=0))
    for _ in range(2):  # twice is enough
        own = own - known @ (known.T @ own)
    left, sizes, _ = np.linalg.svd(own, full_matrices=False)
    sizes = CONSTANTS.accuracy_of_laws * sizes / max(float(np.linalg.norm(sizes)), 1e-12)
    forms = list[Linearised]()
    for place, size in enumerate(sizes):
        if size < CONSTANTS.least_form * CONSTANTS.accuracy_of_laws:
            break
        column = np.zeros(prediction.measured.size)
        column[at] = left[:, place] * np.sqrt(at.size) * size * level
        widest, number = CONSTANTS.widest_form, before + place + 1
        parameter = Parameter(f"form_of_law.{number}", "1", 0.0, 1.0, -widest, widest, spike="form_of_law")
        forms.append(Linearised(parameter, 0.0, column))
    return forms
