"""How does a template become a page? One jinja2 environment, everything escaped, nothing undefined."""

from __future__ import annotations

import re
from functools import lru_cache

import jinja2

from evat.model import Variable
from evat.native import kernel
from evat.units import display


def _shown(value: float, variable: Variable | str, digits: int = 6) -> str:
    return display(value, variable if isinstance(variable, Variable) else kernel.variable(variable), digits=digits)


@lru_cache(maxsize=1)
def _environment() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("evat", "templates"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["shown"] = _shown
    environment.filters["anchor"] = lambda title: "-".join(re.findall(r"[a-z0-9]+", str(title).lower()))
    environment.filters["words"] = lambda name: str(name).replace("_", " ")
    return environment


def render(template: str, **values: object) -> str:
    """The page that `template` makes of `values`."""
    return _environment().get_template(template).render(**values)
