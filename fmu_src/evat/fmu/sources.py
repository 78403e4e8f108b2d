"""Which C files travel in an FMU, and how are they compiled? The tree of model and shell, without the headers of FMI."""

from __future__ import annotations

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


def compiled_sources(version: Version, shown: FmuFacts) -> list[Path]:
    """The C files of one FMI version, in a fixed order."""
    root = source_root()
    return [*model_sources(root, shown.model), *shell_sources(root, version)]


def source_names(version: Version, shown: FmuFacts) -> tuple[str, ...]:
    """Their names inside sources/."""
    root = source_root()
    return tuple(path.relative_to(root).as_posix() for path in compiled_sources(version, shown))


def source_files(version: Version, shown: FmuFacts) -> dict[str, bytes]:
    """Everything below sources/, buildDescription.xml included."""
    root = source_root()
    paths = (*compiled_sources(version, shown), *model_headers(root, shown.model))
    files = {f"sources/{path.relative_to(root).as_posix()}": path.read_bytes() for path in paths}
    files["sources/fmi/model.h"] = model_header(shown)  # found without an include folder
    files["sources/buildDescription.xml"] = build_description(version, shown)
    return files


def model_header(shown: FmuFacts) -> bytes:
    """The FMU's model.h: that of its model, with the values that it has at the start beside the table's."""
    text = (source_root() / "fmus" / shown.model / "model.h").read_bytes()
    if not shown.start:
        return text
    places = {variable.name: variable for variable in (kernel.variables() if shown.model == CONTACT else machine.variables(shown.model))}
    rows = ", ".join(f"{{{places[name].index}, {places[name].check(value)!r}}}" for name, value in shown.start.items())
    return text + f"\n/* {', '.join(shown.start)} */\n#define STARTS {rows}\n".encode()


def build_description(version: Version, shown: FmuFacts) -> bytes:
    """buildDescription.xml. Its format is FMI 3's in an FMI 2 archive, too."""
    document = top("fmiBuildDescription", {"fmiVersion": "3.0"})
    text = "C99 with its mathematical library; the headers of FMI are the importer's"
    configuration = add(document, "BuildConfiguration", {"modelIdentifier": shown.model_name, "description": text})
    options = " ".join(flag for flag in FLAGS if flag.startswith(("-std", "-ff", "-fv")))
    files = add(configuration, "SourceFileSet", {"language": "C99", "compiler": "clang", "compilerOptions": options})
    for name in source_names(version, shown):
        add(files, "SourceFile", {"name": name})
    for name in sorted({name.partition("/")[0] for name in source_names(version, shown)}):
        add(files, "IncludeDirectory", {"name": name})
    return serialised(document)


def binary_name(version: Version, target: Target, shown: FmuFacts) -> str:
    """Where the archive keeps the library of one platform."""
    folder = target.fmi2_folder if version == 2 else target.fmi3_folder
    return f"binaries/{folder}/{shown.model_name}{target.extension}"


def compile_binary(version: Version, target: Target, shown: FmuFacts, folder: Path) -> bytes:
    """The library of one platform; `folder` holds it while it is made.

    The shell is compiled from a copy beside the FMU's own model.h, as it travels; the model from where it lies, with the same command for
    all FMUs, so that the compiler's cache has it from the second one on.
    """
    output = folder / f"fmi{version}" / target.fmi3_folder / f"{shown.model_name}{target.extension}"
    root, shell = source_root(), output.parent / "fmi"
    for path in (*shell_sources(root, version), *sorted((root / "fmi").glob("*.h"))):
        put(shell / path.name, path.read_bytes())
    put(shell / "model.h", model_header(shown))
    sources = [*model_sources(root, shown.model), *(shell / path.name for path in shell_sources(root, version))]
    include = [include_folders(root, shown.model)[0], fmi_headers()]
    return compile_library(sources, output, target, include=include).read_bytes()
