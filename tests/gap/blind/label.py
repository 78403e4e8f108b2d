"""What is to be known of a case afterwards? Where its gap lies, whether it can be seen, and what else would look like it."""

from __future__ import annotations

from typing import Any

import numpy as np
from noise import Noise
from radau import Array
from refit import Refit, Whitener, difference, projected, sensitivity
from rigs import Setup
from where import places
from world import Acting, Cause, Channels

SEEN = 5.0  # standard deviations
ALIKE = 0.2  # of a gap left by another cause: 4 % of its square, less than forms differ


def free_values(setup: Setup) -> list[str]:
    """What a refit may move."""
    values = setup.world.values
    return [name for name in values if name not in setup.exact and setup.relative_sd[name] > 0 and values[name] > 0]


def hold_of(setup: Setup, noise: float) -> dict[str, float]:
    """How strongly each free value clings to the truth in a refit of forces in units of their rms: by what its owner knows of it."""
    return {name: noise / setup.relative_sd[name] for name in free_values(setup)}


def label_of(setup: Setup, acting: Acting, noise: Noise, fitted: Refit, repeats: int, plain: list[Channels],
             nominal: dict[str, float], others: dict[str, list[Cause]]) -> dict[str, Any]:  # fmt: skip
    """All but what the draw itself knows.

    seen: standard deviations of the gap after the ideal refit; off: those by which the nominal values alone are off; where: the smallest
    boxes that hold 80 % of the squared gap of each channel that matters; places: all of these, and others hardly larger; twins: other
    causes that would explain the gap to within what can be seen, or all but a fifth; seen_beside: of each cause of a pair, what the other
    does not explain.
    """
    world = setup.world
    label: dict[str, Any] = {
        "effects": [cause.name for cause, _ in acting], "form": "right" if world.form.right else "wrong",
        "causes": [{"name": c.name, "strength": s, "shape": dict(c.shape)} for c, s in acting], "kinematics": world.kind,
        "channels": list(world.channels), "base_form": world.form.__dict__, "values": dict(world.values),
        "excitation": list(world.excitation), "gap_rms": fitted.size,
        "gap_over_noise": {name: fitted.size[name] / noise.rms[name] for name in world.channels},
        "where": [], "places": {}, "detectable": False, "seen": 0.0, "twins": [], "seen_beside": {},
    }  # fmt: skip
    whiten = Whitener(world, plain, noise.rms, noise.jitter, noise.memory, repeats)
    label["off"] = norm(whiten(difference(plain, world.respond(nominal))))
    if not acting:
        return label
    free = free_values(setup)
    J, hold = sensitivity(world, free, whiten), 1 / np.array([setup.relative_sd[name] for name in free])
    gap = difference([{n: part[n] + left[n] for n in part} for part, left in zip(plain, fitted.gap, strict=True)], plain)
    r = whiten(gap)
    label["seen"] = norm(projected(r, J, hold))
    label["detectable"] = label["seen"] > SEEN
    label["places"] = places(world, fitted.gap)
    label["where"] = [region for ways in label["places"].values() if ways[-1] for region in ways[0]]
    for name, causes in others.items():
        columns = np.stack([whiten(difference(world.respond(causes=[(c, 0.3 * c.typical)]), plain)) for c in causes], axis=1)
        beside = projected(r, np.concatenate([J, columns], axis=1), np.concatenate([hold, np.zeros(len(causes))]))
        if norm(beside) < max(SEEN, ALIKE * label["seen"]):
            label["twins"].append(name)
    for place, (cause, _) in enumerate(acting if len(acting) > 1 else ()):
        rest = [one for k, one in enumerate(acting) if k != place]
        column = whiten(difference(world.respond(causes=rest), plain))[:, None]
        label["seen_beside"][cause.name] = norm(projected(r, np.concatenate([J, column], axis=1), np.append(hold, 0.0)))
    return label


def norm(r: Array) -> float:
    return float(np.sqrt(r @ r))
