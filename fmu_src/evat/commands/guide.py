"""`evat guide`: where is the manual?"""

from __future__ import annotations

import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from evat.console import out


def guide(
    path: Annotated[bool, typer.Option("--path", help="Print where its first page lies; open nothing.")] = False,
    build: Annotated[bool, typer.Option("--build", help="Build it anew from its pages and the kernel's tables; open nothing.")] = False,
    notebooks: Annotated[
        Path | None, typer.Option("--notebooks", help="Write its four notebooks (.ipynb) into this folder; open nothing.")
    ] = None,
) -> None:
    """Open the guide in the browser: a manual with tables of everything, offline.

    Example: evat guide --path
    """
    from evat import guide as site

    if notebooks is not None:
        from evat.guide.notebooks import write

        for path_of_notebook in write(site.pages(), notebooks):
            out.print(f"wrote {path_of_notebook}", soft_wrap=True, highlight=False)
        return
    if build:
        out.print(f"wrote {site.build()}", soft_wrap=True, highlight=False)
        return
    first = site.first_page()
    if path or not webbrowser.open(first.as_uri()):
        out.print(str(first), soft_wrap=True, highlight=False)
