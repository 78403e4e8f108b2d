"""How does a page of the guide become a notebook? Its text and its blocks of Python are the cells, in their order; what a block prints
and the picture below it are its output.

A hook of mkdocs, by its path: the site holds each notebook beside its page.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from pathlib import Path
from typing import Any

from evat.files.writing import put

PRINTED = "# -> "  # before each line that a block prints
PREFIX = "notebook-"  # how their pages are named
BLOCK = re.compile(r"^(?:<!-- not run: [^\n]+ -->\n)?```python\n(.*?)^```$", re.DOTALL | re.MULTILINE)
PICTURE = re.compile(r"\s*!\[[^\]]*\]\(([^)]+)\)")  # below a block: the figure that it makes
_LINK = re.compile(r"\[([^\]]+)\]\((?!https?:)[^)]+\)")  # to another page, which does not lie beside a notebook


def notebook(page: str, folder: Path) -> str:
    """The page, whose pictures lie in `folder`, as a Jupyter notebook (nbformat 4.5); the same page gives the same bytes."""
    cells: list[dict[str, Any]] = []
    for place, text in enumerate(BLOCK.split(page)):
        picture = None if place % 2 else PICTURE.match(text)
        if picture is not None:
            cells[-1]["outputs"].append(_figure(folder / picture[1]))
        source = text.strip() if place % 2 else _LINK.sub(r"*\1*", text[picture.end() if picture else 0 :]).strip()
        if not source:
            continue
        cell: dict[str, Any] = {"cell_type": "markdown", "metadata": {}, "source": source.splitlines(keepends=True)}
        if place % 2:
            cell |= {"cell_type": "code", "execution_count": None, "outputs": _printed(source)}
        cells.append({"id": hashlib.sha256(f"{len(cells)}\0{source}".encode()).hexdigest()[:8], **cell})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    about = {"kernelspec": kernel, "language_info": {"name": "python"}}
    return json.dumps({"cells": cells, "metadata": about, "nbformat": 4, "nbformat_minor": 5}, indent=1, ensure_ascii=False) + "\n"


def _printed(source: str) -> list[dict[str, Any]]:
    """What the lines behind PRINTED say that a block prints, which the tests hold it to; nothing where that is cut short."""
    lines = [line.removeprefix(PRINTED) + "\n" for line in source.splitlines() if line.startswith(PRINTED)]
    whole = lines and not any("..." in line for line in lines)
    return [{"output_type": "stream", "name": "stdout", "text": lines}] if whole else []


def _figure(picture: Path) -> dict[str, Any]:
    image = base64.b64encode(picture.read_bytes()).decode("ascii")
    return {"output_type": "display_data", "data": {"image/png": image}, "metadata": {}}


def file_name(page: Path) -> str:
    """Of the notebook of a page."""
    return f"{page.stem.removeprefix(PREFIX)}.ipynb"


def write(pages: Path, folder: Path) -> list[Path]:
    """The notebooks of all pages in the folder `pages`."""
    sources = sorted(pages.glob(f"{PREFIX}*.md"))
    return [put(folder / file_name(page), notebook(page.read_text(encoding="utf-8"), pages)) for page in sources]


def on_files(files: Any, config: Any, **_: Any) -> Any:
    """mkdocs: the notebooks join the files of the site."""
    from mkdocs.structure.files import File

    for page in sorted(Path(config["docs_dir"]).glob(f"{PREFIX}*.md")):
        files.append(File.generated(config, file_name(page), content=notebook(page.read_text(encoding="utf-8"), page.parent)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """mkdocs: a page that is a notebook offers it below its title."""
    source = Path(page.file.src_uri)
    if not source.name.startswith(PREFIX):
        return markdown
    title, _blank, rest = markdown.partition("\n")
    return f"{title}\n\n[The same as a Jupyter notebook]({file_name(source)}); `evat guide --notebooks FOLDER` writes them all.\n{rest}"
