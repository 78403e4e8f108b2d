"""Does the project set itself up from nothing, and does compiling do what it says on every target?"""

from __future__ import annotations

import ast
import ctypes
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from evat import fmu
from evat.files.read_toml import read_toml
from evat.fmu import build_fmu, host
from evat.native.compile import (
    TARGETS,
    CompileError,
    Target,
    build_machine_library,
    compile_library,
    fmi_headers,
    host_target,
    include_folders,
    kernel_library_path,
    kernel_sources,
    machine_library_path,
    model_sources,
    seal_of,
    shell_sources,
    source_root,
)
from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ("run.py", "test.py")
MAGIC = {"linux": b"\x7fELF", "windows": b"MZ", "darwin": b"\xcf\xfa\xed\xfe"}


def c_file(folder: Path, text: str, name: str = "unit.c") -> Path:
    path = folder / name
    path.write_text(text, encoding="ascii")
    return path


def run_script(script: str, before: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run build/`script` after the statements `before`, which take something away from the machine."""
    code = f"import sys, runpy; sys.path.insert(0, 'build'); {before}; runpy.run_path('build/{script}', run_name='__main__')"
    return subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, env={**os.environ, **environment}, check=False, timeout=120
    )


@pytest.mark.parametrize("script", SCRIPTS)
def test_an_old_python_is_told_so_and_can_read_that_far(script: str) -> None:
    ast.parse((ROOT / "build" / script).read_text(encoding="utf-8"), feature_version=(3, 4))
    result = run_script(script, "sys.version_info = (3, 9, 18)")
    assert result.returncode == 1
    assert "needs Python 3.10 or newer" in result.stderr
    assert "is 3.9" in result.stderr
    assert "Traceback" not in result.stderr


def test_build_is_no_package() -> None:
    """build/__init__.py would hide the PyPI package of that name."""
    assert not (ROOT / "build" / "__init__.py").exists()


def test_the_setup_uses_the_standard_library_only() -> None:
    for name in (*SCRIPTS, "environment.py"):
        tree = ast.parse((ROOT / "build" / name).read_text(encoding="utf-8"))
        imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
        imported |= {node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
        assert {module.partition(".")[0] for module in imported} - {"environment"} <= set(sys.stdlib_module_names)


def test_a_python_without_ensurepip_is_told_what_to_install(tmp_path: Path) -> None:
    """As on Debian without python3-venv."""
    before = (
        "import environment, importlib.util; from pathlib import Path; find = importlib.util.find_spec; "
        "importlib.util.find_spec = lambda name: None if name == 'ensurepip' else find(name); "
        f"environment.ROOT = Path({str(tmp_path)!r})"
    )
    result = run_script("test.py", before)
    assert result.returncode == 1
    assert "venv or ensurepip is missing" in result.stderr
    assert "apt install python3" in result.stderr
    assert "Traceback" not in result.stderr


def test_an_unreachable_registry_is_named_as_such(tmp_path: Path) -> None:
    """No address answers on port 9 of this machine."""
    (tmp_path / "pyproject.toml").write_text(
        '[build-system]\nrequires = ["hatchling"]\nbuild-backend = "hatchling.build"\n', encoding="ascii"
    )
    before = (
        "import environment; from pathlib import Path; "
        f"environment.set_up = lambda root: environment.install(Path(sys.executable), Path({str(tmp_path)!r}), {str(tmp_path)!r})"
    )
    nowhere = {"PIP_INDEX_URL": "http://127.0.0.1:9/simple", "PIP_FIND_LINKS": "", "PIP_RETRIES": "0", "PIP_CONFIG_FILE": os.devnull}
    result = run_script("test.py", before, PIP_NO_INDEX="0", PIP_EXTRA_INDEX_URL="", **nowhere)
    assert result.returncode == 1
    assert "registry could not be reached" in result.stderr
    assert "PIP_INDEX_URL" in result.stderr
    assert "Traceback" not in result.stderr


def test_uv_looks_for_packages_where_pip_does(tmp_path: Path) -> None:
    """The variables of pip before its file, several values each with the separator that uv wants."""
    (tmp_path / "pip.conf").write_text(
        "[global]\nindex-url = https://a.invalid/simple\ntimeout = 7\n[install]\nfind-links =\n    /one\n    /two\n", encoding="ascii"
    )
    before = "import environment; from pathlib import Path; print(environment.uv_settings(Path(sys.executable))); sys.exit(0)"
    without = {name: "" for name in os.environ if name.startswith("PIP_")}
    result = run_script("test.py", before, **without, PIP_CONFIG_FILE=str(tmp_path / "pip.conf"), PIP_INDEX_URL="https://b.invalid/simple")
    settings = ast.literal_eval(result.stdout)
    assert settings["UV_DEFAULT_INDEX"] == "https://b.invalid/simple"
    assert settings["UV_FIND_LINKS"] == "/one,/two"
    assert settings["UV_HTTP_TIMEOUT"] == "7"


def test_variables_of_uv_itself_hold_before_settings_of_pip() -> None:
    before = (
        "import environment, subprocess; from pathlib import Path; run = subprocess.run; "
        "told = lambda command, **how: print(how['env']['UV_HTTP_TIMEOUT']) or sys.exit(0) if '-m uv ' in ' '.join(command) else "
        "(run(command, **how) if 'config' in command else subprocess.CompletedProcess(command, 0)); "
        "subprocess.run = told; environment.install(Path(sys.executable), Path(), '.')"
    )
    assert run_script("test.py", before, UV_HTTP_TIMEOUT="5", PIP_DEFAULT_TIMEOUT="7").stdout.splitlines()[-1] == "5"


def test_a_broken_environment_is_named(tmp_path: Path) -> None:
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    python = tmp_path / ".venv" / "bin" / "python"
    python.write_text("#!/bin/sh\nexit 3\n", encoding="ascii")
    python.chmod(0o755)
    result = run_script("run.py", f"import environment; from pathlib import Path; environment.ROOT = Path({str(tmp_path)!r})")
    assert result.returncode == 1
    assert "does not start. Remove that folder" in result.stderr


@pytest.mark.parametrize(
    ("failing", "status"), [((), 0), (("lint",), 3), (("tests",), 3), (("format", "tests"), 3), (("build the FMUs",), 3)]
)
def test_the_status_is_that_of_the_first_failing_step(failing: tuple[str, ...], status: int) -> None:
    before = (
        "import environment; from pathlib import Path; environment.set_up = lambda root: Path('bin'); "
        f"failing = {failing!r}; say = lambda *words: sys.stdout.write(' '.join(words) + chr(10)); "  # a line whole, from either thread
        "environment.step = lambda title, command, more=None: (say('step', title, *command), 3 + failing.index(title) "
        "if title in failing else 0)[1]; sys.argv[1:] = ['-k', 'law']"
    )
    result = run_script("test.py", before)
    assert result.returncode == status
    steps = [line for line in result.stdout.splitlines() if line.startswith("step")]
    beside = next(line for line in steps if line.endswith("evat build --host-only"))  # at whatever time among the others
    steps.remove(beside)
    assert [line.split()[1] for line in steps] == ["format", "C", "lint", "imports", "types", "build", "tests"]
    assert steps[-1].endswith("-k law")


def test_where_all_tests_run_they_are_compiled_beside_the_build() -> None:
    before = (
        "import environment; from pathlib import Path; environment.set_up = lambda root: Path('bin'); "
        "say = lambda *words: sys.stdout.write(' '.join(words) + chr(10)); "
        "environment.step = lambda title, command, more=None: say('step', *command) and 0"
    )
    steps = [line for line in run_script("test.py", before).stdout.splitlines() if line.startswith("step") and " pytest " in line]
    assert ["--collect-only" in step for step in steps] == [True, False]


def test_the_programs_of_a_step_keep_the_modules_that_they_compile() -> None:
    ask = "import sys; sys.exit(sys.dont_write_bytecode)"
    before = f"import environment; sys.exit(environment.step('ask', [sys.executable, '-c', {ask!r}]))"
    assert run_script("test.py", before, PYTHONDONTWRITEBYTECODE="1").returncode == 0


@pytest.mark.parametrize("target", [t for key, t in TARGETS.items() if key != "x86_64-windows"], ids=lambda target: target.fmi3_folder)
def test_every_target_compiles_offline_and_twice_the_same(target: Target, tmp_path: Path) -> None:
    """x86_64-windows, whose runtime takes more than a minute to build once, is compiled with the FMU below."""
    source = c_file(tmp_path, "#include <math.h>\nint answer(double x); int answer(double x) { return (int)(exp(x) + 0.5); }\n")
    header = c_file(tmp_path, "int answer(double x);\n", "answer.h")
    made = []
    for folder in ("first", "second"):
        output = tmp_path / folder / f"unit{target.extension}"
        compile_library([source], output, target, include=[header.parent], exports=[header.name])
        assert [path.name for path in output.parent.iterdir()] == [output.name]
        made.append(output.read_bytes())
    assert made[0] == made[1]
    assert made[0].startswith(MAGIC[target.system])
    assert b"answer" in made[0]
    assert str(tmp_path).encode() not in made[0]


@pytest.mark.usefixtures("unoptimised")
def test_the_contact_compiles_for_another_platform(tmp_path: Path) -> None:
    """All of its C for Windows without a warning, where the warnings of other systems differ; not linked, which takes minutes at first."""
    root = source_root()
    sources, include = [*model_sources(root), *shell_sources(root, 3)], [*include_folders(root), fmi_headers()]
    objects = list(compile_library(sources, tmp_path / "objects", TARGETS["x86_64-windows"], include=include, link=False).iterdir())
    assert len(objects) == len(sources)
    assert all(each.read_bytes().startswith(b"\x64\x86") for each in objects)  # of a COFF object for this processor


@pytest.mark.campaign
def test_the_contact_is_built_for_all_platforms(tmp_path: Path) -> None:
    with zipfile.ZipFile(build_fmu(3, tmp_path / "contact.fmu", set(TARGETS))) as built:
        binaries = {Path(name).parts[1]: built.read(name) for name in built.namelist() if name.startswith("binaries/")}
    assert set(binaries) == set(TARGETS)
    for key, binary in binaries.items():
        assert binary.startswith(MAGIC[TARGETS[key].system])


def test_a_library_of_this_machine_runs(tmp_path: Path) -> None:
    source = c_file(tmp_path, "int answer(void); int answer(void) { return ANSWER; }\nint hidden(void); int hidden(void) { return 1; }\n")
    c_file(tmp_path, "int answer(void);\n", "answer.h")
    output = tmp_path / f"unit{host_target().extension}"
    compile_library([source], output, host_target(), include=[tmp_path], exports=["answer.h"], defines={"ANSWER": 42})
    library = ctypes.CDLL(str(output))
    assert library.answer() == 42
    assert not hasattr(library, "hidden")


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("int f(double); int f(double x) { int y = x; return y; }\n", "unit.c:1.*-Wfloat-conversion"),
        ("int f(", "unit.c:1"),
        ('int g(void); __attribute__((visibility("default"))) int f(void); int f(void) { return g(); }\n', "undefined symbol: g"),
    ],
)
def test_c_that_does_not_compile_says_where_and_keeps_the_old_library(text: str, complaint: str, tmp_path: Path) -> None:
    output = tmp_path / "out" / "unit.so"
    output.parent.mkdir()
    output.write_bytes(b"old")
    with pytest.raises(CompileError, match=rf"unit\.so: the C compiler refused(.|\n)*{complaint}"):
        compile_library([c_file(tmp_path, text)], output, TARGETS["x86_64-linux"])
    assert output.read_bytes() == b"old"
    assert list(output.parent.iterdir()) == [output]


def test_a_wrong_request_says_what_is_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(CompileError, match="no such source file"):
        compile_library([tmp_path / "absent.c"], tmp_path / "x.so", host_target())
    with pytest.raises(CompileError, match="no C source"):
        compile_library([], tmp_path / "x.so", host_target())
    with pytest.raises(CompileError, match="allowed is 2 or 3"):
        shell_sources(source_root(), 4)
    monkeypatch.setattr("platform.machine", lambda: "riscv64")
    with pytest.raises(CompileError, match=r"riscv64-.*the targets are x86_64-linux"):
        host_target()


def test_a_missing_compiler_names_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(CompileError, match=r"pip install 'evat\[build\]'"):
        compile_library([c_file(tmp_path, "int x;\n")], tmp_path / "x.so", host_target())
    with pytest.raises(CompileError, match="fmpy"):
        fmi_headers()


def test_sources_are_found_and_apart() -> None:
    root = source_root()
    kernel = kernel_sources(root)
    assert {"lugre.c", "registry.c", "thermal_softening.c"} <= {path.name for path in kernel}
    two, three = (shell_sources(root, version) for version in (2, "3"))
    assert not {path.name for path in two if path.name.startswith("fmi3")}
    assert not {path.name for path in three if path.name.startswith("fmi2")}
    assert not set(kernel) & set(two + three)
    assert root / "kernel" in include_folders(root)


def test_a_library_is_compiled_anew_only_where_it_changed(tmp_path: Path) -> None:
    """A small one. That of the kernel is compiled anew, to the same bytes, in tests/models/test_kept.py."""
    library = build_machine_library(tmp_path, "spindle")
    first = library.stat().st_mtime_ns
    assert build_machine_library(tmp_path, "spindle").stat().st_mtime_ns == first
    (tmp_path / f"{library.name}.sha256").write_text("another state", encoding="ascii")
    assert build_machine_library(tmp_path, "spindle").stat().st_mtime_ns != first
    assert library.read_bytes() == machine_library_path("spindle").read_bytes()  # what Python loads is that of these sources


@pytest.mark.skipif(host_target().system != "linux", reason="reads the symbols of an ELF file")
def test_the_kernel_shows_its_header_and_needs_only_math(tmp_path: Path) -> None:
    nm = shutil.which("nm")
    if nm is None:
        pytest.skip("nm is not installed")

    def symbols(option: str) -> set[str]:
        listed = subprocess.run([nm, "-D", option, str(kernel_library_path())], capture_output=True, text=True, check=True).stdout
        return {line.split()[-1].partition("@")[0] for line in listed.splitlines()}

    header = (source_root() / "kernel" / "kernel.h").read_text(encoding="utf-8")
    shown = symbols("--defined-only")
    assert shown == {name for name in shown if name.startswith("kernel_") and f"{name}(" in header}
    assert {"kernel_variable", "kernel_advance", "kernel_run_record"} <= shown
    libm = ctypes.CDLL("libm.so.6")
    assert {name for name in symbols("--undefined-only") if not hasattr(libm, name)} <= {"memcpy", "memset", "memmove", "memcmp", "strcmp"}


def test_objects_are_made_one_for_each_source(tmp_path: Path) -> None:
    root = source_root()
    sources = model_sources(root, "spindle")
    include = [*include_folders(root, "spindle"), root / "kernel"]
    folder = compile_library(sources, tmp_path / "objects", host_target(), include=include, link=False)
    assert len(list(folder.iterdir())) == len(sources) > 3
    assert all(path.suffix == ".o" for path in folder.iterdir())


def test_a_wheel_is_built_with_what_the_package_depends_on_and_an_editable_install_without() -> None:
    """As pip asks: the FMUs in a wheel are made by the package."""
    ask = "import backend; print(*backend.get_requires_for_build_{}(), sep=chr(10))"
    needed = {}
    for kind in ("wheel", "editable"):
        path = {**os.environ, "PYTHONPATH": str(ROOT / "build")}
        done = subprocess.run([sys.executable, "-c", ask.format(kind)], cwd=ROOT, env=path, capture_output=True, text=True, check=True)
        needed[kind] = set(done.stdout.splitlines())
    declared = {str(Requirement(each)) for each in read_toml(ROOT / "pyproject.toml")["project"]["dependencies"]}
    assert declared <= {str(Requirement(each)) for each in needed["wheel"]}
    assert not declared & needed["editable"]


def test_the_wheel_is_for_one_platform_and_holds_libraries_fmus_and_sources(tmp_path: Path) -> None:
    """What is compiled already is not compiled again for it."""
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)], cwd=ROOT, check=True, capture_output=True
    )
    (wheel,) = tmp_path.glob("*.whl")
    assert wheel.name.endswith(f"-py3-none-{host_target().wheel}.whl")
    held = zipfile.ZipFile(wheel)
    names = set(held.namelist())
    for path in (host.host_fmu(version, part) for version in host.VERSIONS for part in fmu.parts()):
        for each in (path, seal_of(path)):
            assert held.read(f"evat/_fmus/{each.name}") == each.read_bytes()
    library = f"evat/_lib/{kernel_library_path().name}"
    assert held.read(library) == kernel_library_path().read_bytes()
    assert held.read(f"{library}.sha256") == seal_of(kernel_library_path()).read_bytes()  # what says that it is whole
    for source in ("kernel/kernel.h", "kernel/friction/lugre.c", "fmi/fmi2.c", "fmi/fmi3.c", "guide/index.md", "guide/pictures/record.png"):
        assert held.read(f"evat/_source/{source}") == (ROOT / "fmu_src" / source).read_bytes()
    assert {"evat/parameters/lugre-1995.toml", "evat/parameters/paper/table-1.toml", "evat/py.typed"} <= names
    assert "Root-Is-Purelib: false" in held.read(next(name for name in names if name.endswith("/WHEEL"))).decode()
    assert not [name for name in names if name.startswith(("tests", "build", "kernel"))]
