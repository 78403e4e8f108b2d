"""What does averaging = cycle cost, and how wrong is it, where the contact moves a machine that moves the contact?

The same system twice: averaged in steps of the machine, and every cycle followed in steps that are short beside one. In between lies all
that the long step loses: the averaging itself, the coupling, and the machine's own answer to 20 kHz.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from evat.model import FloatArray, ParameterError, Trace
from evat.studies.two_scales.study import FORCES, MODES, TwoScales
from evat.systems.couple import Coupled, Plan, plan
from evat.systems.model import Connector, SspError, System
from evat.systems.values import Value, merged, unit, variable

ASKED = (*(f"{name}_impulse" for name in FORCES), "averaging_error", "step_count", "cutting_speed")
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class SystemScales:
    """`cut`: mean forces of each step in both modes, and what they cost, coupling included. `runs[mode]`: what all components showed at
    the ends of the steps; `steps[mode]`: communication step [s]."""

    cut: TwoScales
    runs: Mapping[str, Trace]
    steps: Mapping[str, float]

    def columns(self) -> dict[str, FloatArray]:
        """The cut as columns of a table, a row for each step."""
        cut = self.cut
        table = {"time [s]": cut.times[1:], "cutting_speed [m/s]": cut.speed[1:]}
        table |= {f"mean_{name}_force {mode} [N]": cut.means[mode][:, k] for k, name in enumerate(FORCES) for mode in MODES}
        return {**table, "error [N]": cut.error, "averaging_error [N]": cut.said}

    def machine(self) -> dict[str, tuple[float, float]]:
        """For each output of the partners: its largest value, and the largest difference of both modes, in the unit of the output."""
        largest = {}
        for name, resolved in self.runs["resolved"].columns.items():
            if name.partition(".")[0] != self.runs["resolved"].made_by["contact"]:
                largest[name] = float(np.abs(resolved).max()), float(np.abs(self.runs["cycle"][name] - resolved).max())
        return largest


def contact_of(system: System) -> str:
    """The component whose cycles can be averaged."""
    candidates = []
    for name in system.components:
        try:
            kinds = [variable(system, (name, wanted)).type for wanted in ("averaging", *ASKED)]
        except SspError:
            continue
        candidates += [name] * (kinds[0] == "Enumeration")
    if len(candidates) != 1:
        raise SspError(
            f"{system.name}: {len(candidates)} of its components ({', '.join(system.components)}) have a choice 'averaging'; exactly one "
            "is compared. Our system for it is evat_turning.ssp."
        )
    return candidates[0]


def compare(
    system: System,
    values: Mapping[str, Mapping[str, Value]] | None = None,
    *,
    step: float = 1e-3,
    fine: float | None = None,
    stop: float | None = None,
    progress: Progress = lambda _mode, _share: None,
) -> SystemScales:
    """Run the system in both modes.

    Parameters
    ----------
    step : of the averaged run [s]; both runs are compared at its ends.
    fine : of the run that follows every cycle [s]; without it the system's own. `step` must be a whole multiple of it.
    """
    name = contact_of(system)
    resolved = plan(system, fine, stop, 1)
    every = round(step / resolved.step) if 0 < step < np.inf else 0
    if every < 1 or abs(every * resolved.step / step - 1) > 1e-9 or round((resolved.stop - resolved.start) / step) < 2:
        raise ParameterError(
            f"a step of {step:g} s against one of {resolved.step:g} s over {resolved.stop - resolved.start:g} s: at least 2 steps are "
            "needed, and they must be a whole multiple of the fine step."
        )
    length = resolved.stop - resolved.start
    count = round(length / step)
    if abs(count * step / length - 1) > 1e-9:
        before = int(length / step)
        near = " or ".join(f"{resolved.start + whole * step:.9g} s" for whole in (before, before + 1) if whole >= 2)
        raise ParameterError(
            f"a stop at {resolved.stop:.9g} s is no whole number of steps of {step:g} s from {resolved.start:g} s on, and both runs are "
            f"compared at the ends of the steps: stop at {near}, or take another step."
        )
    plans = {
        "resolved": replace(resolved, stop=resolved.start + count * step, every=every),
        "cycle": Plan(step, resolved.start, resolved.start + count * step),
    }
    more = {asked: Connector(asked, "output", unit(system, (name, asked))) for asked in ASKED}
    contact = replace(system.components[name], connectors={**system.components[name].connectors, **more})
    watched = replace(system, components={**system.components, name: contact})
    runs, seconds = {}, {}
    for mode in reversed(MODES):  # the cheap one first: what it does not take ends the comparison at once
        with Coupled(watched, merged(values or {}, {name: {"averaging": mode}})) as coupled:
            begin = time.process_time()
            runs[mode], _ = coupled.run(plans[mode], lambda share, mode=mode: progress(mode, share))  # type: ignore[misc]
            seconds[mode] = time.process_time() - begin
        runs[mode] = replace(runs[mode], made_by={**runs[mode].made_by, "contact": name})
    impulses = {mode: np.column_stack([run[f"{name}.{asked}"] for asked in ASKED[:3]]) for mode, run in runs.items()}
    cut = TwoScales(
        runs["cycle"].times,
        runs["cycle"][f"{name}.cutting_speed"],
        {mode: np.asarray(np.diff(impulse, axis=0) / step) for mode, impulse in impulses.items()},
        runs["cycle"][f"{name}.averaging_error"][1:],
        seconds,
        {mode: float(run[f"{name}.step_count"][-1]) for mode, run in runs.items()},
    )
    return SystemScales(cut, runs, {mode: one.step for mode, one in plans.items()})
