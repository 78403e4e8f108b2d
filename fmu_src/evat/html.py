"""How does a template become a page? One jinja2 environment, everything escaped, nothing undefined; cells of tables know their heads, so
that a phone can show a row as a block instead of a table that is wider than it."""

from __future__ import annotations

import re
from functools import lru_cache

import jinja2
from lxml import html

from evat.model import Variable
from evat.native import kernel
from evat.units import display

PHONE_WIDTH = 700  # pixels of a page, up to which all that stands side by side comes in one column
INLINE = 24  # characters of a cell that stands beside others on a phone


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
    environment.globals["phone_width"] = PHONE_WIDTH
    environment.filters["shown"] = _shown
    environment.filters["anchor"] = lambda title: "-".join(re.findall(r"[a-z0-9]+", str(title).lower()))
    environment.filters["words"] = lambda name: str(name).replace("_", " ")
    return environment


def render(template: str, **values: object) -> str:
    """The page that `template` makes of `values`."""
    page = _environment().get_template(template).render(**values)
    return re.sub(r"<table\b.*?</table>", lambda table: _labelled(table[0]), page, flags=re.DOTALL)


def _labelled(markup: str) -> str:
    """The table with each cell's head beside the cell; as it is where a head spans several columns, or none tells them."""
    table = html.fragment_fromstring(markup)
    heads, *rows = table.iter("tr")
    labels = [" ".join(head.text_content().split()) for head in heads if head.tag == "th" and not {"colspan", "rowspan"} & set(head.keys())]
    if len(labels) != len(heads):
        return markup
    table.set("class", f"{table.get('class', '')} labelled".strip())
    heads.set("class", "heads")
    for row in (each for each in rows if len(each) == len(labels)):
        for place, (cell, label) in enumerate(zip(row, labels, strict=True)):
            if place:
                cell.set("data-head", label)
            long = len(cell.text_content().strip()) > INLINE or cell.find("div") is not None
            if look := "long" if long else "" if cell.text_content().strip() else "none":
                cell.set("class", f"{cell.get('class', '')} {look}".strip())
    text: str = html.tostring(table, encoding="unicode", with_tail=False)
    return text
