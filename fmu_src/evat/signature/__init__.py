"""What does an effect do to a record? Forces without and with it, over a vibration cycle, a slip to and fro, and the conditions.

No effect is named here: every condition of a fixed list is swept, and those are shown first in which the effect shows most. Forces are the
measured ones, so that effects of measurement show, too. SI throughout.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from evat.model import Effect, EvatError, FloatArray, ParameterError
from evat.native import kernel
from evat.required_inputs import check_required_inputs
from evat.signature.conditions import CONDITIONS
from evat.signature.runs import PROXY, RECORDED, Axis, Case, one_cycle, to_and_fro

TOLERANCE = 1e-5  # relative, of the runs: finer than any difference that is worth a look
NUMERICAL_SHARE = 1e-4  # a share that is no more than what the tolerance leaves


@dataclass(frozen=True, slots=True)
class SignaturePanel:
    """One quantity over another, without and with the effect, in SI."""

    title: str
    across: Axis
    up: Axis
    over: tuple[FloatArray, FloatArray]  # the places without and with the effect, which differ where a path is drawn
    without: FloatArray
    with_effect: FloatArray

    @property
    def share(self) -> float:
        """Root mean square of the difference, as a share of that of the larger one: 0 where the effect does not show."""
        off, there, apart = (float(np.sqrt(np.mean(y**2))) for y in (self.without, self.with_effect, self.with_effect - self.without))
        return apart / max(off, there) if apart > 0 else 0.0

    @property
    def shows(self) -> bool:
        return self.share > NUMERICAL_SHARE

    @property
    def varies(self) -> bool:
        """Whether there is anything to see along the axis: a line changes by more than 1 % of its largest value."""
        return any(np.ptp(y) > 0.01 * np.max(np.abs(y)) for y in (self.without, self.with_effect))


@dataclass(frozen=True, slots=True)
class Signature:
    """An effect's traces: `cycle` has a panel for each of RECORDED, `conditions` have one each, that in which the effect shows most first.

    A condition along which nothing changes comes last.
    """

    effect: Effect
    values: Mapping[str, float]  # of the effect's parameters
    beside: tuple[str, ...]  # effects that are on in both
    cycle: tuple[SignaturePanel, ...]
    rig: SignaturePanel
    conditions: tuple[SignaturePanel, ...]
    left_out: tuple[str, ...]  # conditions that could not be run, and why


def effect_named(name: str) -> Effect:
    """The effect of that name; ParameterError with the nearest names where there is none."""
    effects = {effect.name: effect for effect in kernel.effects()}
    if name in effects:
        return effects[name]
    near = difflib.get_close_matches(name, effects, n=3, cutoff=0.5)
    hint = f"did you mean {', '.join(near)}?" if near else "`evat effects` lists them all."
    raise ParameterError(f"there is no effect {name!r}; {hint}")


def _telling(panels: Sequence[SignaturePanel]) -> SignaturePanel:
    """The panel in which the effect shows most; a temperature only where no force shows it."""
    forces = [panel for panel in panels if panel.up.name != PROXY and panel.shows]
    return max(forces or panels, key=lambda panel: (panel.varies, panel.share))


def signature(name: str, values: Mapping[str, float | str] | None = None, on: Sequence[str] = ()) -> Signature:
    """Run the contact without and with an effect.

    Parameters
    ----------
    name : the effect.
    values : parameters and constant inputs that both have, by the component's names, in SI; the conditions set those they sweep.
    on : effects that are on in both; the effect itself and its rivals are left out of them.

    Raises
    ------
    ParameterError, for an unknown name, a value out of bounds or a missing input; SimulationError, where the nominal run breaks off.
    """
    effect = effect_named(name)
    beside = tuple(other for other in on if other != name and other not in effect.rivals)
    check_required_inputs(kernel.ContactTables(), (*beside, name), values or {})
    numbers = {"relative_tolerance": TOLERANCE, **kernel.check_values(values or {}, beside)}
    for switch in (name, *effect.rivals):
        numbers.pop(switch, None)
    without, with_effect = Case(numbers), Case({**numbers, name: 1.0})

    clock, off = one_cycle(without)
    _, there = one_cycle(with_effect)
    time = Axis.of("time")
    cycle = tuple(SignaturePanel("over one vibration cycle", time, Axis.of(f), (clock, clock), off[f], there[f]) for f in RECORDED)

    off, there = to_and_fro(without), to_and_fro(with_effect)
    slip = Axis("slip to and fro", "m", "um")
    loops = [
        SignaturePanel("over the slip of a friction rig", slip, Axis.of(f), (off["slip"], there["slip"]), off[f], there[f])
        for f in RECORDED
    ]

    conditions, left_out = [], []
    for condition in CONDITIONS:
        try:
            places, answers_off = condition.answers(without)
            _, answers_there = condition.answers(with_effect)
        except EvatError as error:
            left_out.append(f"{condition.title}, over {condition.across.name}: {error}")
            continue
        panels = [
            SignaturePanel(condition.title, condition.across, up, (places, places), answers_off[up], answers_there[up])
            for up in answers_off
        ]
        conditions.append(_telling(panels))
    return Signature(
        effect=effect,
        values={variable.name: numbers.get(variable.name, variable.start) for variable in effect.variables},
        beside=beside,
        cycle=cycle,
        rig=_telling(loops),
        conditions=tuple(sorted(conditions, key=lambda panel: (not panel.varies, -panel.share))),
        left_out=tuple(left_out),
    )
