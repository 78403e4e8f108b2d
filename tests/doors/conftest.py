"""What do the tests of the doors share? Instances that are freed."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from raw_fmi import Door, Instance

Make = Callable[..., Instance]


@pytest.fixture
def make(door: Door) -> Iterator[Make]:
    made: list[Instance] = []

    def maker(**facts: object) -> Instance:
        made.append(Instance(door, **facts))  # type: ignore[arg-type]
        return made[-1]

    yield maker
    for instance in made:
        instance.free()
