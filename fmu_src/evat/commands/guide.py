"""`evat guide`: where is the manual?"""

from __future__ import annotations

import webbrowser
from typing import Annotated

import typer

from evat.console import out


def guide(
    path: Annotated[bool, typer.Option("--path", help="Print where its first page lies; open nothing.")] = False,
    build: Annotated[bool, typer.Option("--build", help="Build it anew from its pages and the kernel's tables; open nothing.")] = False,
) -> None:
    """Open the guide in the browser: a manual with tables of everything, offline.

    Example: evat guide --path
    """
    from evat import guide as site

    if build:
        out.print(f"wrote {site.build()}", soft_wrap=True, highlight=False)
        return
    first = site.first_page()
    if path or not webbrowser.open(first.as_uri()):
        out.print(str(first), soft_wrap=True, highlight=False)
