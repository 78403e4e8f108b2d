"""How does the C become a shared library, for this machine and for every other? One place for compiler, flags and targets.

The compiler is the PyPI package `ziglang`, which compiles for every target offline. Standard library only: the package's own build
loads this file by its path (build/hatch_build.py), before anything is installed. The sanitizers are the one exception: ziglang ships no
AddressSanitizer, so they need a gcc on the machine.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.util
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING or __package__ == "evat.native":
    from evat.model import EvatError
else:
    EvatError = Exception  # the package's build loads this file alone

KERNEL_LIBRARY = "evat_kernel"
CONTACT = "evat_contact"  # the part whose model is the kernel; every other is a partner
COUPLING = "coupling"  # what steps coupled FMUs: in no FMU itself
PACKAGE = Path(__file__).resolve().parent.parent

# One set of flags for the Python library and for every FMU, so that both give the same bits: no contraction, no fast-math, the
# baseline processor of the architecture.
MANY_LANES = 8  # one to four vectors of today's processors; more do not pay
FLAGS = (
    "-std=c99",
    "-ffp-contract=off",
    "-fno-math-errno",  # nobody reads errno, and sqrt is then one instruction
    "-Wno-pass-failed",  # a loop over lanes that is not worth vectors stays one
    "-Wall",
    "-Wextra",
    "-Wshadow",
    "-Wconversion",
    "-Werror",
    "-fvisibility=hidden",
)
RELEASE = ("-O2", "-g0", "-fomit-frame-pointer", "-fno-sanitize=undefined")  # zig's cc else keeps the pointer, and puts checks in
SANITIZE = (
    "-O1",
    "-g",
    "-fno-omit-frame-pointer",
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=undefined,float-cast-overflow",
)


@dataclass(frozen=True)
class Processor:
    """A processor that a library is compiled for: compiler flags, and the instructions without which it cannot be loaded."""

    name: str  # in the library's name
    flags: tuple[str, ...]
    needs: frozenset[str] = frozenset()  # as evat.native.processor names them


BASELINE = Processor("", ("-mcpu=baseline",))
# Many lanes are compiled for these too, best first, and the machine that loads them chooses. Wider vectors, the same arithmetic.
WIDER: dict[str, tuple[Processor, ...]] = {
    "x86_64": (
        Processor(
            "avx512",
            ("-mcpu=baseline+avx512f+avx512dq+avx512bw+avx512vl", "-mprefer-vector-width=512"),
            frozenset({"AVX512F", "AVX512DQ", "AVX512BW", "AVX512VL"}),
        ),
        Processor("avx2", ("-mcpu=baseline+avx2",), frozenset({"AVX2"})),
    )
}


class CompileError(EvatError):
    """C that could not be compiled, or no compiler to do it (`pip install 'evat[build]'`).

    Examples
    --------
    >>> import evat
    >>> issubclass(evat.CompileError, evat.EvatError)
    True
    """


@dataclass(frozen=True)
class Target:
    """A platform that libraries are compiled for."""

    zig: str
    fmi2_folder: str
    fmi3_folder: str
    extension: str
    wheel: str  # its tag in the name of a Python wheel

    @property
    def machine(self) -> str:
        return self.fmi3_folder.partition("-")[0]

    @property
    def system(self) -> str:
        return self.fmi3_folder.partition("-")[2]


# Keyed by the platform tuple of FMI 3. The versions are the oldest systems served: glibc 2.17 (manylinux2014), macOS 11.
TARGETS: dict[str, Target] = {
    target.fmi3_folder: target
    for target in (
        Target("x86_64-linux-gnu.2.17", "linux64", "x86_64-linux", ".so", "manylinux_2_17_x86_64.manylinux2014_x86_64"),
        Target("aarch64-linux-gnu.2.17", "aarch64-linux", "aarch64-linux", ".so", "manylinux_2_17_aarch64.manylinux2014_aarch64"),
        Target("x86_64-windows-gnu", "win64", "x86_64-windows", ".dll", "win_amd64"),
        Target("x86_64-macos.11.0", "darwin64", "x86_64-darwin", ".dylib", "macosx_11_0_x86_64"),
        Target("aarch64-macos.11.0", "aarch64-darwin", "aarch64-darwin", ".dylib", "macosx_11_0_arm64"),
    )
}


def host_target() -> Target:
    """The target that this Python runs on."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(platform.machine().lower(), platform.machine().lower())
    key = f"{machine}-{platform.system().lower()}"
    if key not in TARGETS or sys.maxsize < 2**32:
        raise CompileError(f"no library can be compiled for {key} ({platform.architecture()[0]}); the targets are {', '.join(TARGETS)}.")
    if TARGETS[key].system == "linux" and platform.libc_ver()[0] != "glibc":
        raise CompileError(f"no library can be compiled for {key} without glibc; use a Python that is built on glibc.")
    return TARGETS[key]


def source_root() -> Path:
    """The folder of the C sources, kernel/ and its neighbours: beside the package in a checkout, in the package once installed."""
    places = (PACKAGE / "_source", PACKAGE.parent)
    for place in places:
        if (place / "kernel" / "kernel.h").is_file():
            return place
    raise CompileError(f"the C sources are not there; looked for kernel/kernel.h in {places[0]} and {places[1]}. Install evat again.")


def kernel_sources(root: Path) -> list[Path]:
    """The C files of the kernel, sorted."""
    return sorted((root / "kernel").rglob("*.c"))


def machine_names(root: Path) -> tuple[str, ...]:
    """The partners of the contact: one C file each in machines/parts."""
    return tuple(sorted(source.stem for source in (root / "machines" / "parts").glob("*.c")))


def model_sources(root: Path, part: str = CONTACT) -> list[Path]:
    """The C files of the model in the FMU `part`: the kernel, or a partner with what all partners and what all models share."""
    if part == CONTACT:
        return kernel_sources(root)
    if part not in machine_names(root):
        raise CompileError(f"there is no part {part!r}; allowed are {', '.join((CONTACT, *machine_names(root)))}.")
    return [root / "kernel" / "shared.c", *sorted((root / "machines").glob("*.c")), root / "machines" / "parts" / f"{part}.c"]


def model_headers(root: Path, part: str = CONTACT) -> list[Path]:
    """The headers that model and shell of `part` are compiled with."""
    model = sorted((root / "kernel").rglob("*.h"))
    if part != CONTACT:
        model = [*sorted((root / "machines").rglob("*.h")), *(root / "kernel" / name for name in ("names.h", "shared.h", "tables.h"))]
    return [*model, *sorted((root / "fmi").glob("*.h"))]


def shell_sources(root: Path, version: int | str) -> list[Path]:
    """The C files of the FMI 2 or FMI 3 shell (`version` 2 or 3), without the model's, sorted."""
    other = {"2": "fmi3", "3": "fmi2"}.get(str(version))
    if other is None:
        raise CompileError(f"FMI version {version!r}: allowed is 2 or 3.")
    return [source for source in sorted((root / "fmi").glob("*.c")) if not source.name.startswith(other)]


def include_folders(root: Path, part: str = CONTACT) -> tuple[Path, ...]:
    """Where the headers of model and shell are; `fmi_headers` has the FMI standard's."""
    model = "kernel" if part == CONTACT else "machines"
    return (root / model, root / "fmi")


def fmi_headers() -> Path:
    """The folder of the FMI 2 and FMI 3 headers, which the package fmpy brings."""
    spec = importlib.util.find_spec("fmpy")
    if spec is None or not spec.submodule_search_locations:
        raise CompileError("the FMI headers come with the package fmpy, which is not installed here: pip install fmpy.")
    return Path(spec.submodule_search_locations[0]) / "c-code"


def sanitizer_runtime() -> Path:
    """The AddressSanitizer library that a program must load first (LD_PRELOAD) to load a library compiled with sanitize=True."""
    result = subprocess.run([*_sanitizing_compiler(), "-print-file-name=libasan.so"], capture_output=True, text=True, check=False)
    path = Path(result.stdout.strip())
    if not path.is_absolute() or not path.exists():
        raise CompileError("gcc has no AddressSanitizer here (libasan.so); install it, on Debian: apt install libasan8.")
    return path.resolve()


def compile_library(
    sources: Iterable[Path],
    output: Path,
    target: Target,
    *,
    include: Iterable[Path] = (),
    defines: Mapping[str, str | int] | Iterable[str] = (),
    exports: Iterable[str] = (),
    link: bool = True,
    sanitize: bool = False,
    processor: Processor = BASELINE,
) -> Path:
    """Compile C `sources` into the shared library `output`, which appears whole or not at all.

    `exports` names headers whose functions the library shows although they carry no export mark. With link=False `output` is a folder
    that gets one object file for each source, named by its folder and name. sanitize=True compiles for this machine with
    AddressSanitizer and UndefinedBehaviorSanitizer (see sanitizer_runtime).
    """
    sources = [Path(source).resolve() for source in sources]
    missing = [str(source) for source in sources if not source.is_file()]
    if missing or not sources:
        raise CompileError(f"{output.name}: " + (f"no such source file: {', '.join(missing)}." if missing else "no C source was named."))
    if sanitize and target != host_target():
        raise CompileError(f"{output.name}: the sanitizers run on this machine only, not on {target.fmi3_folder}.")
    if isinstance(defines, Mapping):
        defines = [f"{name}={value}" for name, value in defines.items()]
    if sanitize:
        command = [*_sanitizing_compiler(), *FLAGS, *SANITIZE]
    else:
        command = [*compiler(), "-target", target.zig, *FLAGS, *RELEASE, *processor.flags]
    command += [f"-I{Path(folder).resolve()}" for folder in include] + [f"-D{define}" for define in defines]
    if target.system != "windows":
        command.append("-fPIC")
    if target.system == "linux" and link and not sanitize:
        command.append("-flto")  # across files a seventh of each step goes; the linkers for the other systems refuse it
    with _scratch_folder(output) as scratch:
        if includes := [f'#include "{header}"\n' for header in exports]:
            text = "#pragma GCC visibility push(default)\n" + "".join(includes) + "#pragma GCC visibility pop\n"
            (scratch / "exports.h").write_text(text, encoding="ascii")
            command += ["-include", "exports.h"]
        if link:
            result = scratch / output.name
            strict = [] if sanitize else _link_flags(target, output.name)
            _call([*command, *map(str, sources), "-shared", "-o", result.name, *strict, "-lm"], scratch, output)
        else:
            result = scratch / "objects"
            result.mkdir()
            for source in sources:
                _call([*command, "-c", str(source), "-o", f"objects/{source.parent.name}_{source.stem}.o"], scratch, output)
            if output.exists():
                shutil.rmtree(output)
        os.replace(result, output)  # what else the linker left (.lib, .pdb) goes with the scratch folder
    return output


def _processors(lanes: int) -> tuple[Processor, ...]:
    """What the kernel with so many lanes is compiled for, best first."""
    return (BASELINE,) if lanes == 1 else (*WIDER.get(host_target().machine, ()), BASELINE)


def _library_name(lanes: int, processor: Processor) -> str:
    return "_".join(filter(None, (KERNEL_LIBRARY, "" if lanes == 1 else str(lanes), processor.name))) + host_target().extension


def build_kernel_library(output_dir: Path, lanes: int = 1, processor: Processor = BASELINE) -> Path:
    """The kernel for Python in `output_dir`, compiled only where its sources, flags or compiler have changed.

    `lanes` contacts run side by side in one block of the library.
    """
    output = output_dir / _library_name(lanes, processor)
    return _build_if_changed(output, CONTACT, "kernel.h", {"LANES": lanes}, processor)


def build_machine_library(output_dir: Path, part: str) -> Path:
    """A partner for Python, likewise."""
    return _build_if_changed(output_dir / _plain_library_name(part), part, "machine.h", {}, BASELINE)


def build_coupling_library(output_dir: Path) -> Path:
    """What steps coupled FMUs, likewise."""
    return _build_if_changed(output_dir / _plain_library_name(COUPLING), COUPLING, "coupling.h", {}, BASELINE)


def _build_if_changed(output: Path, part: str, header: str, defines: Mapping[str, str | int], processor: Processor) -> Path:
    root, target = source_root(), host_target()
    sources, _, include = _library_inputs(root, part)
    state = f"{sources_digest(root, part)} {_compiler_version()}".rstrip()
    if not is_whole(output, state):
        seal_of(output).unlink(missing_ok=True)
        compile_library(sources, output, target, include=include, exports=[header], defines=defines, processor=processor)
        seal(output, state)
    return output


def seal_of(path: Path) -> Path:
    """The file beside a file that is kept, which says what it was made from, and what its bytes were."""
    return path.with_name(f"{path.name}.sha256")


def seal(path: Path, made_from: str = "-") -> None:
    """Write down that the file is as it was made."""
    text = f"{made_from}\n{hashlib.sha256(path.read_bytes()).hexdigest()}\n"
    if __package__ == "evat.native":
        from evat.files.writing import put

        put(seal_of(path), text)
    else:  # in the package's own build
        seal_of(path).write_text(text, encoding="ascii")


def is_whole(path: Path, made_from: str | None = None) -> bool:
    """Whether a file that is kept is there as it was made, and where that is asked, from this; by which compiler need not be asked."""
    try:
        kept_from, digest = seal_of(path).read_text(encoding="ascii").splitlines()
        return made_from in (None, kept_from, kept_from.partition(" ")[0]) and hashlib.sha256(path.read_bytes()).hexdigest() == digest
    except (OSError, ValueError):
        return False


def build_libraries(output_dir: Path) -> list[Path]:
    """The kernel with one lane and with many, every partner, and what steps coupled FMUs: side by side, since linking has one thread."""
    builds: list[Callable[[], Path]] = [
        partial(build_kernel_library, output_dir, lanes, processor) for lanes in (1, MANY_LANES) for processor in _processors(lanes)
    ]
    builds += [partial(build_machine_library, output_dir, part) for part in machine_names(source_root())]
    builds.append(partial(build_coupling_library, output_dir))
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        try:
            return list(pool.map(lambda build: build(), builds))
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            stop_compilers()
            raise


def kernel_library_path(lanes: int = 1, instructions: Collection[str] = ()) -> Path:
    """The compiled kernel that came with this package: the best for a machine with these instructions."""
    fits = next(processor for processor in _processors(lanes) if processor.needs <= set(instructions))
    return _compiled(_library_name(lanes, fits), CONTACT, lambda folder: build_kernel_library(folder, lanes, fits))


def machine_library_path(part: str) -> Path:
    """The compiled partner that came with this package."""
    if part not in machine_names(source_root()):
        raise CompileError(f"there is no partner {part!r}; allowed are {', '.join(machine_names(source_root()))}.")
    return _compiled(_plain_library_name(part), part, lambda folder: build_machine_library(folder, part))


def coupling_library_path() -> Path:
    """The compiled library that came with this package and steps coupled FMUs."""
    return _compiled(_plain_library_name(COUPLING), COUPLING, build_coupling_library)


def _plain_library_name(part: str) -> str:
    return f"evat_{part}{host_target().extension}"


def _compiled(name: str, part: str, build: Callable[[Path], Path]) -> Path:
    """A library of this package, whole and of these very sources: to load half of one ends the process, and so does one whose tables are
    not laid out as the headers here say. Any other is compiled anew."""
    path = PACKAGE / "_lib" / name
    if is_whole(path, sources_digest(source_root(), part)):
        return path
    if not path.is_file():
        raise CompileError(
            f"the compiled library is not there: {path}. In a checkout run `python -m evat.native.compile`; else install evat again, "
            "which compiles it."
        )
    flaw = "was compiled from other sources" if is_whole(path) else "is damaged, or nothing says that it is whole"
    warnings.warn(f"{path}: the compiled library {flaw}; it is compiled anew.", stacklevel=2)
    try:
        return build(path.parent)
    except EvatError as error:
        flaw = flaw.partition(",")[0]
        raise CompileError(f"{path}: the compiled library {flaw} and cannot be compiled anew: {error} Install evat again.") from error


def compiler() -> list[str]:
    """The command that compiles C; CompileError where there is none."""
    if importlib.util.find_spec("ziglang") is None:
        raise CompileError(f"no C compiler: the package ziglang is not installed for {sys.executable}: pip install 'evat[build]'.")
    return [sys.executable, "-m", "ziglang", "cc"]


def _sanitizing_compiler() -> list[str]:
    gcc = shutil.which("gcc")
    if gcc is None:
        raise CompileError("the sanitizers need gcc on this machine, and none was found: install gcc.")
    return [gcc]


def _link_flags(target: Target, name: str) -> list[str]:
    return ["-s", *{"linux": ["-Wl,-z,defs"], "darwin": [f"-Wl,-install_name,@rpath/{name}"], "windows": []}[target.system]]


@contextmanager
def _scratch_folder(output: Path) -> Iterator[Path]:
    """A folder on the same disk as `output`, gone afterwards; CompileError where the disk refuses anything."""
    try:
        if __package__ == "evat.native":
            from evat.files.writing import scratch

            with scratch(output.parent) as made:
                yield made
        else:  # in the package's own build
            output.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=output.parent) as folder:
                yield Path(folder)
    except OSError as error:
        raise CompileError(
            f"{output}: it cannot be compiled there: {error.strerror or error}. Free some space, or check the folder."
        ) from error


_running: set[subprocess.Popen[str]] = set()  # compilers at work, in whatever thread


def stop_compilers() -> None:
    """End the compilers that other threads wait for; these get a CompileError."""
    for process in tuple(_running):
        process.kill()


def _call(command: list[str], folder: Path, output: Path) -> None:
    """Run the compiler in `folder`, where it may leave what it likes; zig keeps its cache in the user's own (ZIG_GLOBAL_CACHE_DIR)."""
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="replace") as process:
        _running.add(process)
        try:
            shown, complained = process.communicate()
        except BaseException:
            process.kill()
            raise
        finally:
            _running.discard(process)
    if process.returncode != 0:
        lines = [line for line in (complained or shown).splitlines() if line.strip()]
        said = "\n  ".join(lines[:12]) or f"exit status {process.returncode}, and it said nothing"
        raise CompileError(f"{output.name}: the C compiler refused:\n  {said}")


def _library_inputs(root: Path, part: str) -> tuple[list[Path], list[Path], tuple[Path, ...]]:
    """C files, headers, and the folders of those, of a library for Python."""
    if part == COUPLING:
        return [root / COUPLING / "coupling.c"], [root / COUPLING / "coupling.h"], (root / COUPLING,)
    return model_sources(root, part), model_headers(root, part), include_folders(root, part)[:1]


def sources_digest(root: Path, part: str) -> str:
    """Of all that the library of a part is compiled from on this machine, but the compiler."""
    digest = hashlib.sha256()
    sources, headers, _ = _library_inputs(root, part)
    for path in (Path(__file__), *sources, *headers):
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    digest.update(host_target().zig.encode())
    return digest.hexdigest()


def _compiler_version() -> str:
    try:
        return importlib.metadata.version("ziglang")
    except importlib.metadata.PackageNotFoundError:
        return ""


if __name__ == "__main__":
    print(*build_libraries(PACKAGE / "_lib"), sep="\n")
