"""Does the kernel keep the rules of its folder? No call but math.h, nothing writable, nothing unregistered, tables that fit."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from evat.model import Effect, Law, Variable
from evat.native import kernel, machine
from evat.native.compile import MANY_LANES, compile_library, host_target, kernel_library_path, source_root

LAWS = kernel.variable("friction_law").choices
VARIABLES = kernel.variables()
KERNEL = source_root() / "kernel"
ffi, library = kernel.library()

# C99, 7.12, the functions of double; and what a compiler may put in for a loop over memory (clang and gcc say so in their manuals).
MATH = """acos asin atan atan2 cos sin tan acosh asinh atanh cosh sinh tanh exp exp2 expm1 frexp ilogb ldexp log log10 log1p log2 logb modf
    scalbn scalbln cbrt fabs hypot pow sqrt erf erfc lgamma tgamma ceil floor nearbyint rint lrint llrint round lround llround trunc fmod
    remainder remquo copysign nan nextafter nexttoward fdim fmax fmin fma"""
ALLOWED = {*MATH.split(), "memcpy", "memmove", "memset"}


# ---- what the compiler makes of it ----


@dataclass(frozen=True)
class Library:
    """A shared library or an object file: names that it shows and needs, and its writable sections that hold anything."""

    shown: frozenset[str]
    needed: frozenset[str]
    writable: frozenset[str]


OF_OBJECT, OF_LIBRARY = 2, 11  # kinds of a table of symbols: the linker's, and the dynamic linker's


def read_elf(path: Path, symbols_of: int = OF_LIBRARY) -> Library:
    """ELF, 64 bits, little-endian: the section headers, then the symbols."""
    data = path.read_bytes()
    assert data[:6] == b"\x7fELF\x02\x01"
    (start,), (size, count, names) = struct.unpack_from("<Q", data, 40), struct.unpack_from("<HHH", data, 58)
    sections = [struct.unpack_from("<IIQQQQIIQQ", data, start + n * size) for n in range(count)]

    def text(table: int, at: int) -> str:
        begin = sections[table][4] + at
        return data[begin : data.index(b"\0", begin)].decode()

    symbols = next(section for section in sections if section[1] == symbols_of)
    rows = list(struct.iter_unpack("<IBBHQQ", data[symbols[4] : symbols[4] + symbols[5]]))[1:]
    named = [(text(symbols[6], name), section) for name, info, _, section, *_ in rows if info >> 4 in (1, 2)]  # global, weak
    return Library(
        frozenset(name for name, section in named if section),
        frozenset(name for name, section in named if not section),
        # write and alloc; but tables of pointers, which the loader writes once, and what it writes for itself
        frozenset(text(names, s[0]) for s in sections if s[2] & 3 == 3 and s[5] > 0)
        - {".data.rel.ro", ".relro_padding", ".dynamic", ".got", ".got.plt"},
    )


ELF = pytest.mark.skipif(host_target().system != "linux", reason="reads the sections of an ELF file")
# What Python loads, optimised as a whole, with what the compiler has put in: one contact at a time, and many.
LIBRARIES = pytest.mark.parametrize("path", [kernel_library_path(), kernel_library_path(MANY_LANES)], ids=lambda path: path.name)


@ELF
@LIBRARIES
def test_the_kernel_calls_the_mathematical_library_and_nothing_else(path: Path) -> None:
    kernel_library = read_elf(path)
    assert {"kernel_advance", "kernel_run_record"} <= kernel_library.shown
    assert "pow" in kernel_library.needed  # the reader sees what is called
    assert kernel_library.needed - ALLOWED == set()


@ELF
@LIBRARIES
def test_nothing_writable_outlives_a_call_but_what_the_caller_owns(path: Path) -> None:
    assert read_elf(path).writable == set()


@ELF
def test_a_writable_static_and_a_foreign_call_are_seen(tmp_path: Path) -> None:
    """The reader itself, on C that breaks both rules."""
    source = tmp_path / "bad.c"
    source.write_text("#include <stdlib.h>\nstatic int calls;\nvoid *f(void);\nvoid *f(void) { ++calls; return malloc((size_t)calls); }\n")
    (tmp_path / "bad.h").write_text("void *f(void);\n")
    bad = compile_library([source], tmp_path / "bad.so", host_target(), include=[tmp_path], exports=["bad.h"])
    assert read_elf(bad) == Library(frozenset({"f"}), frozenset({"malloc"}), frozenset({".bss"}))


# ---- tables ----


def test_the_readme_has_the_question_of_every_file() -> None:
    """One line each, room by room, in the words with which the file itself begins."""
    text = (KERNEL / "README.md").read_text(encoding="utf-8")
    listed = dict(re.findall(r"^- `(\w+\.[ch])`: (.+)$", text, re.MULTILINE))
    files = [path for room in (".", "solver", "history", "averaging") for path in sorted((KERNEL / room).glob("*.[ch]"))]
    assert list(listed) == [path.name for path in files]
    for path in files:
        begins = re.sub(r"\s*\n \*\s?", " ", path.read_text(encoding="utf-8").removeprefix("/* "))
        assert begins.startswith(listed[path.name]), path.name


def test_every_file_of_a_law_or_effect_is_registered_and_no_other() -> None:
    assert sorted(LAWS) == sorted(path.stem for path in (KERNEL / "friction").glob("*.c"))
    assert sorted(effect.name for effect in kernel.effects()) == sorted(path.stem for path in (KERNEL / "effects").glob("*.c"))
    owners: tuple[Law | Effect, ...] = (*kernel.laws(), *kernel.effects())
    for owner in owners:
        assert min(map(len, (owner.meaning, owner.equation, owner.source))) > 0, owner.name
        assert all(v.name.startswith(f"{owner.name}.") for v in owner.variables)


def test_the_tables_fit_a_contact_and_are_sound() -> None:
    assert len(VARIABLES) <= library.CAPACITY
    assert len({v.name for v in VARIABLES}) == len(VARIABLES)
    assert sorted(v.derivative_of for v in VARIABLES if v.derivative_of) == sorted(kernel.states())
    for v in VARIABLES:
        assert v.min <= v.start <= v.max, v.name
        assert v.nominal > 0, v.name
        assert v.meaning, v.name
        assert v.source, v.name
        assert v.causality not in ("parameter", "input") or np.isfinite([v.start, v.min, v.max]).all(), v.name
        assert v.type != "choice" or (v.min, v.max) == (0, len(set(v.choices)) - 1), v.name


def test_a_table_says_of_each_work_whether_it_was_read() -> None:
    """A year stands for a work. Of LuGre 1995, which two dozen rows name, the guide says it once."""
    rows: tuple[Variable | Law | Effect, ...] = (*VARIABLES, *kernel.laws(), *kernel.effects(), *machine.variables("tool_heat"))
    sources = {row.source.replace("Canudas de Wit et al. 1995", "") for row in rows}
    assert any("not read" in source for source in sources)
    for source in sources:
        for clause in source.split(";") if "neither read" not in source else ():
            assert "read" in clause or not re.search(r"\b(1[6-9]|20)\d\d\b", clause), source


@pytest.mark.parametrize("law", LAWS)
def test_what_a_law_remembers_stays_within_its_memory(law: str) -> None:
    """Its own functions, at rest, bent and bent the other way, on a memory with marked room behind it."""
    row, known = library.kernel_law(LAWS.index(law)), kernel.laws()[LAWS.index(law)]
    own = ffi.new("double[][1]", [[v.start] for v in known.variables] or [[0.0]])
    memory = ffi.new("double[][1]", [[0.0]] * library.MEMORY + [[-1234.5]] * 100)
    z, point = ffi.new("double[1]"), ffi.new("struct Point *")
    for field, kind in ffi.typeof("struct Point").fields:
        if kind.type.kind == "array" and kind.type.item.kind == "primitive":
            getattr(point, field)[0] = 1.0
    for z[0] in (0.0, 10.0, -10.0):
        if row.rest:
            row.rest(own, point, memory)
        if row.event:
            row.indicator(own, memory, point)
            row.event(own, point, z, memory)
        assert {memory[library.MEMORY + n][0] for n in range(100)} == {-1234.5}
