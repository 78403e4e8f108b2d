"""How does a page of the guide become a notebook? Its text and its blocks of Python are the cells, in their order.

A hook of mkdocs, by its path: the site holds each notebook beside its page.
"""

from __future__ import annotations

import hashlib
import json
import re
from pathlib import Path
from typing import Any

from evat.files.writing import put

PREFIX = "notebook-"  # how their pages are named
_BLOCK = re.compile(r"^(?:<!-- not run: [^\n]+ -->\n)?```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_LINK = re.compile(r"\[([^\]]+)\]\((?!https?:)[^)]+\)")  # to another page, which does not lie beside a notebook


def notebook(page: str) -> str:
    """The page as a Jupyter notebook (nbformat 4.5); the same page gives the same bytes."""
    cells: list[dict[str, Any]] = []
    for place, text in enumerate(_BLOCK.split(page)):
        source = text.strip() if place % 2 else _LINK.sub(r"*\1*", text).strip()
        if not source:
            continue
        cell: dict[str, Any] = {"cell_type": "markdown", "metadata": {}, "source": source.splitlines(keepends=True)}
        if place % 2:
            cell |= {"cell_type": "code", "execution_count": None, "outputs": []}
        cells.append({"id": hashlib.sha256(f"{len(cells)}\0{source}".encode()).hexdigest()[:8], **cell})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    about = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return json.dumps({"cells": cells, "metadata": about, "nbformat": 4, "nbformat_minor": 5}, indent=1, ensure_ascii=False) + "\n"


def file_name(page: Path) -> str:
    """Of the notebook of a page."""
    return f"{page.stem.removeprefix(PREFIX)}.ipynb"


def write(pages: Path, folder: Path) -> list[Path]:
    """The notebooks of all pages in the folder `pages`."""
    return [put(folder / file_name(page), notebook(page.read_text(encoding="utf-8"))) for page in sorted(pages.glob(f"{PREFIX}*.md"))]


def on_files(files: Any, config: Any, **_: Any) -> Any:
    """mkdocs: the notebooks join the files of the site."""
    from mkdocs.structure.files import File

    for page in sorted(Path(config["docs_dir"]).glob(f"{PREFIX}*.md")):
        files.append(File.generated(config, file_name(page), content=notebook(page.read_text(encoding="utf-8"))))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """mkdocs: a page that is a notebook offers it below its title."""
    source = Path(page.file.src_uri)
    if not source.name.startswith(PREFIX):
        return markdown
    title, _blank, rest = markdown.partition("\n")
    return f"{title}\n\n[The same as a Jupyter notebook]({file_name(source)}); `evat guide --notebooks FOLDER` writes them all.\n{rest}"
