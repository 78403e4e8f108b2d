"""Which C files travel in an FMU, and how are they compiled? The tree of model and shell, without the headers of FMI."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from evat.files.writing import put
from evat.fmu.fmu_facts import FmuFacts, Version
from evat.fmu.part_model import every_variable, fmu_facts_of, model_token, token_of, variants
from evat.fmu.xml import add, serialised, top
from evat.native.compile import (
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

VARIANTS = "fmi/variants.c"  # which the FMUs have of their own
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
    files[f"sources/{VARIANTS}"] = variants_file([(version, fmu_facts)])
    files[f"sources/{NAMES}"] = names(version, fmu_facts)
    files["sources/buildDescription.xml"] = build_description(version, fmu_facts)
    return files


def variants_file(fmus: Sequence[tuple[Version, FmuFacts]]) -> bytes:
    """The file variants.c of a program that is each of these FMUs, as the token says."""
    text = (
        "/* As which FMUs does this program show its model? Of each its token, its starts beside those of the tables, and the\n"
        " * variables that it has. */\n"
        '#include "component.h"\n\n'
    )
    rows = []
    for place, (version, facts) in enumerate(fmus):
        table = {variable.name: variable for variable in every_variable(facts.model)}
        row = f'.name = "{facts.model_name}", .token = "{token_of(version, facts)}",\n     .model = "{model_token(facts.model)}"'
        if facts.start:
            starts = "".join(f"    {{{table[n].index}, {table[n].check(value)!r}}}, /* {n} */\n" for n, value in facts.start.items())
            text += f"static const struct Start starts_{place}[] = {{\n{starts}}};\n"
            row += f",\n     .starts = starts_{place}, .start_count = {len(facts.start)}"
        if facts.shown:
            names = sorted(facts.shown, key=lambda name: table[name].index)
            shown = "".join(f"    {table[name].index}, /* {name} */\n" for name in names)
            text += f"static const uint16_t shown_{place}[] = {{\n{shown}}};\n"
            row += f",\n     .shown = shown_{place}, .count = {len(names)}"
        rows.append(f"    {{{row}}},\n")
    text += f"\nconst struct Variant fmu_variants[] = {{\n{''.join(rows)}}};\nconst int fmu_variant_count = {len(rows)};\n"
    return text.encode()


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


def compile_binary(version: Version, target: Target, model: str, folder: Path) -> bytes:
    """The library of one platform for all FMUs that carry a model; `folder` holds it while it is made.

    But for variants.c, model and shell are compiled from where they lie, with the same command for all models, so that the compiler's
    cache has the shell from the second one on.
    """
    named = fmu_facts_of(model)
    output = folder / f"fmi{version}" / target.fmi3_folder / f"{named.model_name}{target.extension}"
    root = source_root()
    own = output.parent / Path(VARIANTS).name
    put(own, variants_file([(version, facts) for facts in variants(model)]))
    sources = [own if source == root / VARIANTS else source for source in compiled_sources(version, named)]
    include = [*include_folders(root, model), fmi_headers()]
    return compile_library(sources, output, target, include=include).read_bytes()
