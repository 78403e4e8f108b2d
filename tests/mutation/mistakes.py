"""Which small mistakes can be made in a line? In C by a table of exchanges, in Python by the operators of cosmic-ray.

A mistake is told by the line as it was and as it becomes, so that what is said of it stays true where the line moves.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TOKEN = re.compile(
    r"""(?P<space>\s+)|(?P<name>[A-Za-z_]\w*)|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*)
    |(?P<sign><<=|>>=|->|\+\+|--|<<|>>|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|.)""",
    re.VERBOSE,
)
HIDDEN = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#(?:\\\n|[^\n])*', re.DOTALL | re.MULTILINE)
BETWEEN = {  # of two terms
    "+": ("-",),
    "-": ("+",),
    "*": ("/",),
    "/": ("*",),
    "%": ("*",),
    "<": ("<=", ">"),
    ">": (">=", "<"),
    "<=": ("<", ">="),
    ">=": (">", "<="),
    "==": ("!=",),
    "!=": ("==",),
    "&&": ("||",),
    "||": ("&&",),
    "&": ("|",),
    "|": ("&",),
    "<<": (">>",),
    ">>": ("<<",),
    "+=": ("-=",),
    "-=": ("+=",),
    "*=": ("/=",),
    "/=": ("*=",),
    "|=": ("&=",),
    "&=": ("|=",),
}
NAMES = {
    "larger": "smaller",
    "smaller": "larger",
    "fmax": "fmin",
    "fmin": "fmax",
    "fabs": "",
    "sin": "cos",
    "cos": "sin",
    "exp": "-exp",
    "sqrt": "-sqrt",
    "floor": "ceil",
    "ceil": "floor",
    "continue": "break",
}
TYPE = re.compile(r"double|int|char|void|lanes|const|\w+_t|[A-Z][a-z]\w*")  # a star behind it is no product
STATEMENT = re.compile(
    r"^(?:EACH_LANE )?(?!(?:const|static|return|enum|struct|double|int|lanes|uint64_t|case|break|continue|else|goto)\b)\w[^{}]*;$"
)
DATA = re.compile(  # rows of a table: values, no code
    r"^\s*(?:\[\w+(?: \+ \d+)?\] = \{|\.\w+ = |\{?\.name)|\bSTATE\b|\bTUNED\b|\bSWITCH\b|\.source ="
)


@dataclass(frozen=True)
class Mistake:
    """One change of one file."""

    file: str  # from the source root
    line: int  # where it stands today, from 1
    was: str
    becomes: str
    text: str  # the whole file with the mistake

    @property
    def name(self) -> tuple[str, str, str]:
        return (self.file, self.was, self.becomes)


def _visible(text: str) -> str:
    """The text with comments, strings and preprocessor lines blank, at the same places."""
    return HIDDEN.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def _number(text: str) -> tuple[str, ...]:
    if re.fullmatch(r"\d+", text):
        n = int(text)
        return ("1",) if n == 0 else (str(n + 1), str(n - 1)) if n < 10 else (str(2 * n),)
    return (f"({text} * 2)",) if re.fullmatch(r"[\d.eE+-]+", text) else ()


def _changes(line: str) -> Iterator[tuple[int, int, str]]:
    """From, to, and what stands there instead."""
    before = ""  # the token before
    for token in TOKEN.finditer(line):
        kind, text = token.lastgroup, token.group()
        if kind == "space":
            continue
        term = bool(re.fullmatch(r"[\w.]+|\)|\]", before)) and before not in {"return", "case"} and not TYPE.fullmatch(before)
        if kind == "sign" and term:
            for instead in BETWEEN.get(text, ()):
                yield token.start(), token.end(), instead
        elif (kind == "sign" and text in "-!" and not term) or (kind == "name" and text in NAMES):
            yield token.start(), token.end(), NAMES.get(text, "")
        elif kind == "number":
            for instead in _number(text):
                yield token.start(), token.end(), instead
        before = text
    whole = line.strip()
    if STATEMENT.match(whole) and whole.count("(") == whole.count(")"):
        yield line.index(whole), line.index(whole) + len(whole), ";"


def in_c(file: Path, root: Path) -> list[Mistake]:
    """All mistakes of a C file, but in comments, preprocessor lines and the rows of its tables."""
    text = file.read_text(encoding="utf-8")
    lines, mistakes = text.split("\n"), []
    for n, line in enumerate(_visible(text).split("\n")):
        if DATA.search(line):
            continue
        for begin, end, instead in _changes(line):
            changed = lines[n][:begin] + instead + lines[n][end:]
            whole = "\n".join([*lines[:n], changed, *lines[n + 1 :]])
            mistakes.append(Mistake(file.relative_to(root).as_posix(), n + 1, lines[n].strip(), changed.strip(), whole))
    return mistakes


def _difference(ours: list[str], theirs: list[str]) -> tuple[int, str, str]:
    """Where two texts part, from 0, and what each has there until they meet again."""
    begin = next(n for n, pair in enumerate(zip(ours, theirs, strict=False)) if pair[0] != pair[1])
    after = next(n for n, pair in enumerate(zip(ours[begin:][::-1], theirs[begin:][::-1], strict=False)) if pair[0] != pair[1])
    was, becomes = ("\n".join(lines[begin : len(lines) - after]).strip() for lines in (ours, theirs))
    return begin, was, becomes


def places_in_python(file: Path) -> list[tuple[str, int]]:
    """Where the operators of cosmic-ray can act in a file: their names, and the how-manieth time. Counted in one pass; making one takes a
    parse of its own."""
    import parso
    from cosmic_ray.ast import ast_nodes
    from cosmic_ray.plugins import get_operator, operator_names

    tree, places = parso.parse(file.read_text(encoding="utf-8")), []
    for name in sorted(operator_names()):
        if "BinaryOperator_BitOr" in name or "RemoveDecorator" in name or "/Variable" in name or "/variable" in name:
            continue  # `X | None` is a type; a decorator that is gone is a TypeError; those of variables want to be told which
        operator = get_operator(name)()
        count = sum(len(list(operator.mutation_positions(node))) for node in ast_nodes(tree))
        places += [(name, occurrence) for occurrence in range(count)]
    return places


def in_python(file: Path, root: Path, operator: str, occurrence: int) -> Mistake:
    """One mistake of a Python file."""
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator

    text = file.read_text(encoding="utf-8")
    changed = mutate_code(text, get_operator(operator)(), occurrence)
    begin, was, becomes = _difference(text.split("\n"), changed.split("\n"))
    return Mistake(file.relative_to(root).as_posix(), begin + 1, was, becomes, changed)
