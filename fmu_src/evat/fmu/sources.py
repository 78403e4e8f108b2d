"""Which C files travel in an FMU, and how are they compiled? The tree of model and shell, without the headers of FMI."""

from __future__ import annotations

import re
from pathlib import Path

from evat.files.writing import put
from evat.fmu.fmu_facts import FmuFacts, Version
from evat.fmu.xml import add, serialised, top
from evat.native import kernel, machine
from evat.native.compile import (
    CONTACT,
    FLAGS,
    Target,
    compile_library,
    fmi_headers,
    include_folders,
    model_headers,
    model_sources,
    shell_sources,
    source_root,
)

STARTS = "fmi/starts.c"  # which an FMU may have of its own
NAMES = "kernel/names.h"  # which the sources in an FMU have of their own

# A function or an object that a C file defines for others, as clang-format sets it: from the first column, nothing static.
_SHARED = re.compile(r"^(?!static\b|extern\b|typedef\b)(?:[A-Za-z_]\w*[ *]+)+(\w+)(?:\(|(?:\[[^\]]*\])* = )", re.MULTILINE)


def compiled_sources(version: Version, fmu_facts: FmuFacts) -> list[Path]:
    """The C files of one FMI version, in a fixed order."""
    root = source_root()
    return [*model_sources(root, fmu_facts.model), *shell_sources(root, version)]


def source_names(version: Version, fmu_facts: FmuFacts) -> tuple[str, ...]:
    """Their names inside sources/."""
    root = source_root()
    return tuple(path.relative_to(root).as_posix() for path in compiled_sources(version, fmu_facts))


def source_files(version: Version, fmu_facts: FmuFacts) -> dict[str, bytes]:
    """Everything below sources/, buildDescription.xml included."""
    root = source_root()
    paths = (*compiled_sources(version, fmu_facts), *model_headers(root, fmu_facts.model))
    files = {f"sources/{path.relative_to(root).as_posix()}": path.read_bytes() for path in paths}
    files[f"sources/{STARTS}"] = starts(fmu_facts)
    files[f"sources/{NAMES}"] = names(version, fmu_facts)
    files["sources/buildDescription.xml"] = build_description(version, fmu_facts)
    return files


def starts(fmu_facts: FmuFacts) -> bytes:
    """The FMU's starts.c: the values that it has at the start beside the table's."""
    if not fmu_facts.start:
        return (source_root() / STARTS).read_bytes()
    places = {
        variable.name: variable for variable in (kernel.variables() if fmu_facts.model == CONTACT else machine.variables(fmu_facts.model))
    }
    rows = "".join(
        f"    {{{places[name].index}, {places[name].check(value)!r}}}, /* {name} */\n" for name, value in fmu_facts.start.items()
    )
    return (
        "/* Which values does this FMU start with, beside those of its model's tables? */\n"
        f'#include "component.h"\n\nconst struct Start fmu_starts[] = {{\n{rows}    {{MODEL_TIME, 0}},\n}};\n'
    ).encode()


def names(version: Version, fmu_facts: FmuFacts) -> bytes:
    """The FMU's names.h: the names that its files share, with the FMU's in front. Those of FMI have the importer's prefix."""
    shared = {name for path in compiled_sources(version, fmu_facts) for name in _SHARED.findall(path.read_text(encoding="utf-8"))}
    front = f"{fmu_facts.model_name}_fmi{version}_"
    rows = "".join(f"#define {name} {front}{name}\n" for name in sorted(shared) if not name.startswith(f"fmi{version}"))
    question = "By which names does a linker know what these files share? With the FMU's in front, so that nothing else has them."
    return f"/* {question} */\n{rows}".encode()


def build_description(version: Version, fmu_facts: FmuFacts) -> bytes:
    """buildDescription.xml. Its format is FMI 3's in an FMI 2 archive, too."""
    document = top("fmiBuildDescription", {"fmiVersion": "3.0"})
    text = "C99 with its mathematical library; the headers of FMI are the importer's"
    configuration = add(document, "BuildConfiguration", {"modelIdentifier": fmu_facts.model_name, "description": text})
    options = " ".join(flag for flag in FLAGS if flag.startswith(("-std", "-ff", "-fv")))
    files = add(configuration, "SourceFileSet", {"language": "C99", "compiler": "clang", "compilerOptions": options})
    for name in source_names(version, fmu_facts):
        add(files, "SourceFile", {"name": name})
    for name in sorted({name.partition("/")[0] for name in source_names(version, fmu_facts)}):
        add(files, "IncludeDirectory", {"name": name})
    return serialised(document)


def binary_name(version: Version, target: Target, fmu_facts: FmuFacts) -> str:
    """Where the archive keeps the library of one platform."""
    folder = target.fmi2_folder if version == 2 else target.fmi3_folder
    return f"binaries/{folder}/{fmu_facts.model_name}{target.extension}"


def compile_binary(version: Version, target: Target, fmu_facts: FmuFacts, folder: Path) -> bytes:
    """The library of one platform; `folder` holds it while it is made.

    But for starts.c, model and shell are compiled from where they lie, with the same command for all FMUs, so that the compiler's cache has
    them from the second one on.
    """
    output = folder / f"fmi{version}" / target.fmi3_folder / f"{fmu_facts.model_name}{target.extension}"
    root = source_root()
    sources = compiled_sources(version, fmu_facts)
    if fmu_facts.start:
        own = output.parent / Path(STARTS).name
        put(own, starts(fmu_facts))
        sources[sources.index(root / STARTS)] = own
    include = [*include_folders(root, fmu_facts.model), fmi_headers()]
    return compile_library(sources, output, target, include=include).read_bytes()
