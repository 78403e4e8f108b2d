"""How does a command take options that belong together as one value? As a dataclass of options, for which Typer is given its fields."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable
from typing import Any, get_type_hints

KEYWORD = inspect.Parameter.KEYWORD_ONLY


def grouped(command: Callable[..., None]) -> Callable[..., None]:
    """The command with single options in place of each parameter that is a dataclass of them; on the command line nothing tells of it."""
    signature, hints = inspect.signature(command), get_type_hints(command, include_extras=True)
    groups = {name: hints[name] for name in signature.parameters if dataclasses.is_dataclass(hints[name])}
    options: dict[str, inspect.Parameter] = {}
    for name, parameter in signature.parameters.items():
        own = _options_of(groups[name]) if name in groups else [parameter.replace(kind=KEYWORD, annotation=hints[name])]
        options |= {option.name: option for option in own}

    @functools.wraps(command)
    def called(**given: Any) -> None:
        held = {name: group(**{field.name: given.pop(field.name) for field in dataclasses.fields(group)}) for name, group in groups.items()}
        command(**given, **held)

    vars(called)["__signature__"] = signature.replace(parameters=list(options.values()))
    called.__annotations__ = {name: option.annotation for name, option in options.items()}
    return called


def _options_of(group: Any) -> list[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    return [
        inspect.Parameter(
            field.name,
            KEYWORD,
            default=inspect.Parameter.empty if field.default is dataclasses.MISSING else field.default,
            annotation=hints[field.name],
        )
        for field in dataclasses.fields(group)
    ]
