"""How is XML written here? Elements, attributes and numbers; absent attributes are None."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeAlias

from lxml import etree

Scalar: TypeAlias = bool | int | float | str
Attributes: TypeAlias = Mapping[str, Scalar | None]
Element: TypeAlias = Any  # lxml comes without types


def text(value: Scalar) -> str:
    """A value as XML writes it; a float in the shortest form that reads back as the same number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(float(value)) if isinstance(value, float) else str(value)


def attributes(pairs: Attributes) -> dict[str, str]:
    """The pairs as XML attributes; None stands for an absent one."""
    return {name: text(value) for name, value in pairs.items() if value is not None}


def add(parent: Element, tag: str, pairs: Attributes | None = None) -> Element:
    """A new child element."""
    return etree.SubElement(parent, tag, attributes(pairs or {}))


def top(tag: str, pairs: Attributes, namespaces: Mapping[str, str] | None = None) -> Element:
    """A root element."""
    return etree.Element(tag, attributes(pairs), nsmap=namespaces)


def serialised(element: Element) -> bytes:
    """The bytes of an XML file."""
    return bytes(etree.tostring(element, xml_declaration=True, encoding="UTF-8", pretty_print=True))
