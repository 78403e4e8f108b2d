"""How is an XML file read that anybody may have written? Without entities or network, by its schema, and its numbers are numbers."""

from __future__ import annotations

import math
import re
from functools import lru_cache
from importlib import util
from pathlib import Path
from typing import Any

from lxml import etree

from evat.model import ParameterError

_NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")
WHOLE = 2**53  # beyond it a whole number is not told from the next one


class XmlError(ParameterError):
    """An XML file that cannot be used; names file and line."""


def read_xml(source: Path | bytes, what: str) -> Any:
    """The tree of a file, or of its bytes; `what` names it in an error."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, huge_tree=False, remove_comments=True)
    try:
        tree = etree.ElementTree(etree.fromstring(source, parser)) if isinstance(source, bytes) else etree.parse(str(source), parser)
    except (OSError, etree.XMLSyntaxError) as error:
        raise XmlError(f"{what}: this is no readable XML file: {error}.") from error
    if tree.docinfo.internalDTD is not None:
        raise XmlError(f"{what}: it has a document type declaration, which is not needed; remove it.")
    return tree


@lru_cache
def _schema(name: str, version: str) -> Any:
    """Those of SSP 1 come with fmpy; of SSP 2.0, which it has not, they lie beside this file as the Modelica Association gives them."""
    folder = Path(__file__).parent / "ssp2"
    if version != "2.0":
        spec = util.find_spec("fmpy")
        if spec is None or not spec.submodule_search_locations:
            raise XmlError("the SSP schemas come with the package fmpy, which is not installed here: pip install fmpy.")
        folder = Path(spec.submodule_search_locations[0]) / "ssp" / "schema"
    return etree.XMLSchema(file=str(folder / f"{name}{'11' if version == '1.1' and name.endswith('Description') else ''}.xsd"))


def check_valid(tree: Any, name: str, what: str) -> None:
    """XmlError with the line where the tree is not what the schema `name` says, in the version of SSP that the document states."""
    version = tree.getroot().get("version")
    schema = _schema(name, version if version in ("1.1", "2.0") else "1.0")
    if not schema.validate(tree):
        wrong = schema.error_log[0]
        raise XmlError(f"{what}, line {wrong.line}: not valid by the schema of SSP {version or '1.0'}: {wrong.message}")


def number(element: Any, key: str, what: str, default: float | None = None, *, whole: bool = False) -> float:
    """The number in an attribute; `whole`: one of 1, 2, 3 ... Where it is missing, the default if there is one."""
    text = element.get(key)
    if text is None and default is not None:
        return default
    where = f"{what}, line {element.sourceline}"
    needed = f"a whole number from 1 to {WHOLE:g} is needed" if whole else "a finite number is needed"
    if text is None:
        raise XmlError(f"{where}: {key} is missing; {needed}.")
    parsed = float(text) if _NUMBER.fullmatch(text.strip()) else math.nan
    if not math.isfinite(parsed) or (whole and not (1 <= parsed <= WHOLE and parsed == int(parsed))):
        raise XmlError(f"{where}: {key} = {text[:40]!r}; {needed}.")
    return parsed
