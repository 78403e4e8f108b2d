"""Where is the guide, and how is it built? Markdown pages and the kernel's tables in, a site that needs no network out."""

from __future__ import annotations

import importlib.util
import logging
import os
from pathlib import Path

import platformdirs

from evat import __version__
from evat.files.writing import as_output_error, scratch
from evat.guide.seal import SEAL, digest
from evat.model import EvatError
from evat.native.compile import PACKAGE, source_root

TOOLS = ("mkdocs", "material", "mkdocstrings")


class GuideError(EvatError):
    """A guide that is not there, or cannot be built."""


def pages() -> Path:
    """Where the Markdown lies."""
    return source_root() / "guide"


def built_to() -> Path:
    """Where `evat guide --build` puts the site: beside the FMUs in a checkout, with a user's caches otherwise."""
    root = PACKAGE.parent.parent
    if (root / "pyproject.toml").is_file():
        return root / "build" / "out" / "guide"
    return platformdirs.user_cache_path("evat") / f"guide-{__version__}"


def first_page() -> Path:
    """index.html of the guide: the one that was installed, or the one that was built here; GuideError where there is neither."""
    for place in (PACKAGE / "_guide" / "index.html", built_to() / "index.html"):
        if place.is_file():
            return place
    raise GuideError(
        "the guide is not built here; `evat guide --build` does it in some seconds (it needs pip install 'evat[guide]'). Its pages as "
        f"plain text lie in {pages()}."
    )


def check_place(to: Path) -> None:
    """GuideError where the site would replace something that is no guide."""
    if to.exists() and not (to / SEAL).is_file():
        raise GuideError(f"{to}: there is something that is no guide, and is not replaced; name another folder.")


def build(to: Path | None = None) -> Path:
    """Build the site into a folder, in place of an earlier one; its first page. GuideError where a tool is missing or a page is wrong."""
    to = built_to() if to is None else to
    check_place(to)
    if missing := [name for name in TOOLS if importlib.util.find_spec(name) is None]:
        raise GuideError(f"the guide is built by {', '.join(missing)}, which is not installed here: pip install 'evat[guide]'.")
    from mkdocs.commands.build import build as make
    from mkdocs.config import load_config
    from mkdocs.exceptions import Abort, MkDocsException

    logging.getLogger("mkdocs").setLevel(logging.WARNING)
    with as_output_error(to):
        to.parent.mkdir(parents=True, exist_ok=True)
        with scratch(to.parent) as beside:
            made = beside / "guide"
            try:
                make(load_config(str(PACKAGE / "guide" / "mkdocs.yml"), docs_dir=str(pages()), site_dir=str(made)))
            except (Abort, MkDocsException) as error:
                raise GuideError(f"the guide cannot be built: {error}") from error
            (made / "404.html").unlink(missing_ok=True)  # for servers; its links begin at a server's root
            (made / SEAL).write_text(digest(PACKAGE.parent), encoding="ascii")
            if to.exists():
                os.replace(to, beside / "old")
            os.replace(made, to)
    return to / "index.html"
