"""Do steps that end where those of the cycle before did keep to what steps find that remember nothing?"""

from __future__ import annotations

import numpy as np
import pytest
from evat import parameter_sets
from evat.model import FloatArray
from evat.native.kernel import Contact

PERIOD = 1 / 20e3  # s
MEANS = ("mean_friction_force", "mean_principal_force", "mean_feed_force", "mean_contact_ratio")
SETS = ("start values", "regularised/copper", "regularised/al-6061", "regularised/inconel-718", "lugre-1995")
CYCLES = 100


def started(name: str, time: float = 0.0, **values: float | str) -> Contact:
    parameter_set = None if name == "start values" else parameter_sets.load(name)
    given, on = ({}, ()) if parameter_set is None else (dict(parameter_set.values), parameter_set.effects)
    contact = Contact({**given, **values}, on)
    contact.start(time)
    return contact


def cycles(
    contact: Contact, remembers: bool, changes: dict[int, dict[str, float]] | None = None, count: int = CYCLES
) -> tuple[FloatArray, FloatArray]:
    """Means of each cycle, and its steps; `changes`: what is set anew before a cycle."""
    means, steps = [], []
    for n in range(count):
        for name, value in (changes or {}).get(n, {}).items():
            contact.set(name, value)
        if not remembers:
            contact._contact.breakpoint_count[0] = contact._contact.breakpoint_next[0] = 0
            contact._contact.breakpoint_due[0] = np.inf
        before = contact.get("step_count")
        contact.advance(PERIOD)
        steps.append(contact.get("step_count") - before)
        means.append([contact.get(name) for name in MEANS])
    return np.array(means), np.array(steps)


@pytest.mark.parametrize("name", SETS)
def test_cycles_alike_have_the_same_steps_and_means(name: str) -> None:
    """To a tenth of the tolerance of 1e-4, with as many steps; but for the cycles in which steps are chosen anew, as all are without a
    memory, after others: these are within some tolerances of one another."""
    remembered, steps = cycles(started(name), remembers=True)
    anew, as_many = cycles(started(name), remembers=False)
    size = np.max(np.abs(anew), axis=0)
    apart = np.max(np.abs(remembered - anew) / size, axis=1)
    alike = [n for n in range(CYCLES) if n % 34 > 3]
    assert np.max(apart[alike]) < 1e-5
    assert np.max(apart) < 1e-3
    assert np.sum(steps) <= 1.03 * np.sum(as_many)


@pytest.mark.parametrize("time", [10.0, 1e4])
def test_late_cycles_have_as_many_steps(time: float) -> None:
    """Where roundings of the time are wider than an event, a step that aims at it just misses it."""
    _, steps = cycles(started("start values", time), remembers=True)
    _, as_many = cycles(started("start values", time), remembers=False)
    assert np.sum(steps) <= 1.1 * np.sum(as_many)


CHANGES: dict[int, dict[str, float]] = {
    20: {"feed": 6e-6},
    40: {"cutting_speed": 0.3},
    41: {"amplitude_y": 3e-6},
    60: {"F_S": 20.0, "v_s": 1e-4},
    80: {"cutting_speed": 0.1, "rake_angle": 0.1},
}


def test_what_changes_is_not_taken_from_the_cycle_before() -> None:
    """Contact, surface and reversal come elsewhere at once; at a tolerance of 1e-6 every cycle's means are right."""
    remembered, _ = cycles(started("start values", relative_tolerance=1e-6), remembers=True, changes=CHANGES)
    anew, _ = cycles(started("start values", relative_tolerance=1e-6), remembers=False, changes=CHANGES)
    assert np.max(np.abs(np.diff(anew[:, 0]))) > 0.05  # the changes are felt
    assert np.max(np.abs(remembered - anew) / np.max(np.abs(anew), axis=0)) < 1e-5


def test_a_machine_that_carries_the_tool_along_costs_no_more_steps() -> None:
    """Events that come a little later in every cycle are missed where the one before had them."""
    contact = started("start values", kinematics="combined", tool_displacement_y=0.0)
    moved = {n: {"tool_displacement_y": 1e-8 * n} for n in range(CYCLES)}
    _, steps = cycles(contact, remembers=True, changes=moved)
    _, as_many = cycles(started("start values", kinematics="combined"), remembers=False, changes=moved)
    assert np.sum(steps) <= 1.2 * np.sum(as_many)


@pytest.mark.parametrize("name", ["regularised/al-6061", "regularised/inconel-718"])
def test_steps_that_the_tolerance_lets_through_at_the_shortest_are_no_end(name: str) -> None:
    """At 1e-8 a cycle has more ends to aim at than are kept, and some are asked for again that nothing is accurate enough for: one tried a
    hair longer than the shortest step would be tried for ever."""
    parameter_set = parameter_sets.load(name)
    contact = Contact({**parameter_set.values, "relative_tolerance": 1e-8}, parameter_set.effects)
    contact.start()
    contact.advance(CYCLES * PERIOD)
    remembered = [contact.get(mean) for mean in MEANS]
    anew, _ = cycles(started(name, relative_tolerance=1e-8), remembers=False, count=4)
    assert remembered == pytest.approx(anew[-1], rel=1e-7)


def ends(contact: Contact) -> FloatArray:
    """Of the steps that are kept, in their order [s]."""
    count, kept = int(contact._contact.breakpoint_count[0]), len(contact._contact.breakpoint)
    return np.array([contact._contact.breakpoint[n % kept][0] for n in range(max(count - kept, 0), count)])


@pytest.mark.parametrize("name", SETS)
def test_steps_end_where_those_of_the_cycle_before_did(name: str) -> None:
    """To the rounding of the time, where they do; an event is else known to 1e-7 of a step, and a step shorter than one that was too long
    is no better known."""
    contact = started(name)
    for _ in range(6):
        contact.advance(4 * PERIOD)  # so few that none is skipped
    kept = ends(contact)
    last, before = kept[kept > contact.time - PERIOD], kept[kept > contact.time - 2 * PERIOD]
    assert last.size >= 5
    assert before[: last.size] + PERIOD == pytest.approx(last, rel=0, abs=1e-17)


@pytest.mark.parametrize("effect", ["sensor_delay", "regenerative"])
def test_where_a_past_is_kept_steps_remember_none(effect: str) -> None:
    contact = Contact(on=(effect,))
    contact.start()
    contact.advance(40 * PERIOD)
    assert ends(contact).size == 0


@pytest.mark.parametrize("effect", [(), ("thermal_softening",), ("maxwell_slip",), ("amplitude_loss",)], ids=str)
def test_steps_after_a_periodic_start_end_where_those_of_its_search_did(effect: tuple[str, ...]) -> None:
    """The search has run this very cycle; but where it ends in a little, an event lies a little elsewhere."""
    contact = Contact({"initial_state": "periodic"}, effect)
    contact.start()
    searched = ends(contact)
    contact.advance(PERIOD)
    last = ends(contact)
    last = last[last > 0]
    assert last.size >= 5
    nearest = np.min(np.abs(np.subtract.outer(last - PERIOD, searched)), axis=1)
    assert np.mean(nearest < 1e-6 * PERIOD) >= 0.8


def test_averaged_cycles_go_by_those_of_the_steps_before() -> None:
    """However far apart the steps of the machine are: the ends that are kept are those of one cycle after the other."""
    contact = Contact({"averaging": "cycle", "initial_state": "periodic"})
    contact.start()
    for _ in range(20):
        contact.advance(1e-3)
    assert np.ptp(ends(contact)) < 20 * PERIOD
