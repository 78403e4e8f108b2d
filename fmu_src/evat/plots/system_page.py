"""What did a run of a system give, as a page? Signals in numbers and as a picture, the power at its bonds, its components."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from evat import html as pages
from evat.headline import Headline
from evat.model import FloatArray, Trace
from evat.models.drive import unit_of
from evat.notebook.panels import prefixed
from evat.plots.cycles import inline
from evat.plots.system import narrow_run
from evat.systems.couple import Coupled, Plan, SystemMember, means_of_last_half
from evat.systems.power import ALLOWED, Power


def page(coupled: Coupled, trace: Trace, power: Power, plan: Plan, files: Mapping[str, str], picture: Path, untold: str = "") -> str:
    """The page of a run. `files` lie beside it, each with its meaning; `picture` is a .png that is there, `untold` what it leaves out."""
    means = means_of_last_half(trace)
    bonds = [_bond(name, *energies) for name, energies in power.shares().items()]
    return pages.render(
        "system.html.j2",
        system=coupled.system,
        headline=_headline(coupled, trace, power, plan),
        notes=(*coupled.notes, *coupled.given.beyond(plan)),
        signals=[_signal(name, trace.units[name], column, means[name]) for name, column in trace.columns.items()],
        bonds=bonds,
        allowed=ALLOWED,
        values={member.name: [_given(member, *item) for item in coupled.values[member.name].items()] for member in coupled.members},
        feeds={member.name: _feeds(coupled, member.name) for member in coupled.members},
        plan=plan,
        picture=inline(picture.read_bytes()),
        narrow=inline(narrow_run(trace)),
        untold=untold,
        files=files,
    )


def _headline(coupled: Coupled, trace: Trace, power: Power, plan: Plan) -> Headline:
    """Whether the coupling can be believed; without a bond nobody has looked."""
    advice = power.advice(plan.longest, 2 if plan.inputs == "linear" else 1)
    shares = [moved / passed if passed > 0 else 0.0 for passed, _, moved in power.shares().values()]
    ran = f"{coupled.system.title} ran from {trace.times[0]:g} to {trace.times[-1]:g} s in steps of {plan.longest:g} s."
    if not shares:
        return Headline("ran", "note", ran, reasons=("no bond of force and velocity joins the components: no balance of power was kept",))
    if not any(passed > 0 for passed, _, _ in power.shares().values()):
        return Headline("ran", "note", ran, reasons=("no energy passed the bonds: that says nothing of the coupling",))
    largest = max(shares)
    share, share_of = f"{100 * largest:.2g} %", "of the energy that passed its bonds was made or lost by the coupling, counted step by step"
    if largest > ALLOWED:
        longest = advice[int(np.argmax(shares))].rpartition("; ")[2]
        return Headline("steps too long", "attention", ran, share=share, share_of=share_of, next=f"{longest}.")
    return Headline("power kept", "good", ran, share=share, share_of=share_of)


def _given(member: SystemMember, name: str, value: float | str | bool) -> str:
    unit = unit_of(member.driver.variables[name]) if name in member.driver.variables else "1"
    text = f"{value:.6g}" if isinstance(value, (int, float)) and not isinstance(value, bool) else str(value)
    return f"{name} = {text}" + ("" if unit == "1" else f" {unit}")


def _feeds(coupled: Coupled, component: str) -> list[str]:
    """Each input of a component that is fed, and by what: another component, or the record."""
    connected = [f"{to[1]}: {'.'.join(at)}" for to, at in coupled.system.connections.items() if to[0] == component]
    return [*connected, *(f"{at[1]}: the record" for at in coupled.given.ports if at[0] == component)]


def _bond(name: str, passed: float, made: float, moved: float) -> dict[str, object]:
    return {"name": name, "passed": passed, "made": made, "share": moved / passed if passed > 0 else 0.0}


def _signal(name: str, unit: str, column: FloatArray, mean: float) -> dict[str, object]:
    """Its numbers in a unit in which they are read at ease."""
    scale, shown = prefixed(column, unit)
    numbers = (column[0], column[-1], column.min(), column.max(), mean)
    return {"name": name, "unit": "" if shown == "1" else shown, "numbers": [float(scale * each) for each in numbers]}
