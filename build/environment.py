"""How does a fresh machine get the project's private environment, and what do run.py and test.py do in it? Standard library only."""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import os
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EXTRAS = "build,guide,importers,notebook,test"
C_STYLE = f"--style=file:{ROOT / 'fmu_src' / '.clang-format'}"
# What pip says when it cannot reach a registry; it has no exit status of its own for that. Every package named here exists, so finding no
# version of one is such a sign too, and the only one where pip is told not to retry.
UNREACHABLE = (
    "(from versions: none)",
    "connection broken",
    "Could not fetch URL",
    "Failed to establish a new connection",
    "Max retries exceeded",
    "NameResolutionError",
    "Temporary failure in name resolution",
    "Read timed out",
    "ProxyError",
    "Network is unreachable",
)
# Of algebra: with more, the tests that run beside each other wait for processors that neither has.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
# pip's settings that say where packages are, the variable of uv for each, and what stands between several values in it.
UV_VARIABLES = (
    ("index-url", "UV_DEFAULT_INDEX", " "),
    ("extra-index-url", "UV_INDEX", " "),
    ("find-links", "UV_FIND_LINKS", ","),
    ("no-index", "UV_NO_INDEX", " "),
    ("cert", "SSL_CERT_FILE", " "),
    ("trusted-host", "UV_INSECURE_HOST", " "),
    ("timeout", "UV_HTTP_TIMEOUT", " "),
)


class SetupError(Exception):
    """The environment could not be made; the text says why and what to do."""


def main(job: Callable[[Path, Sequence[str]], int]) -> None:
    """Set up, do `job` with the command line's arguments, and exit with its status."""
    try:
        status = job(set_up(ROOT), sys.argv[1:])
    except SetupError as error:
        sys.exit(f"\n{error}")
    except KeyboardInterrupt:
        sys.exit(130)
    sys.exit(status)


def run(scripts: Path, arguments: Sequence[str]) -> int:
    """Build the FMUs, then run the paper's materials with them."""
    evat = str(scripts / "evat")
    return step("build the FMUs", [evat, "build"]) or step("reproduce the paper's figures and mean forces", [evat, "run", *arguments])


def test(scripts: Path, arguments: Sequence[str]) -> int:
    """Every check, pytest last; the status is that of the first that failed. The FMUs are built beside the checks before them, for this
    machine alone: a test builds one for every platform."""
    python = str(scripts / "python")
    side_by_side = [] if _runs_alone(arguments) else ["-n", "2", "--dist", "worksteal"]
    build = "build the FMUs"
    steps = {
        "format": [python, "-m", "ruff", "format", "--check", "."],
        "C format": [str(scripts / "clang-format"), C_STYLE, "--dry-run", "--Werror", *c_files(ROOT)],
        "lint": [python, "-m", "ruff", "check", "."],
        "imports": [str(scripts / "lint-imports")],
        "types": [python, "-m", "mypy"],
        "build the guide": [str(scripts / "evat"), "guide", "--build"],
        # Of a new checkout all tests are compiled: once for those that run side by side, and while the FMUs are built.
        "collect the tests": [python, "-m", "pytest", "--collect-only", "-p", "no:terminal"],
        "tests": [python, "-m", "pytest", *side_by_side, *arguments],
    }
    if arguments:
        del steps["collect the tests"]
    failed: dict[str, int] = {}
    with ThreadPoolExecutor(1) as pool:
        built = pool.submit(step, build, [str(scripts / "evat"), "build", "--host-only"])
        for title, command in steps.items():
            unless_set: dict[str, str] = {}
            if title == "tests":
                unless_set = dict.fromkeys(ONE_THREAD, "1")
                if status := built.result():
                    failed[build] = status
                else:  # the tests drive those
                    unless_set["EVAT_TEST_FMUS"] = str(ROOT / "build" / "out" / "fmus")
                if failed:
                    say(f"failed so far: {', '.join(failed)}")
            if status := step(title, command, unless_set):
                failed[title] = status
    return next(iter(failed.values()), 0)


def c_files(root: Path) -> list[str]:
    """Every C file of the project, as the formatter is given them."""
    return [str(path.relative_to(root)) for folder in ("fmu_src", "tests") for path in sorted((root / folder).rglob("*.[ch]"))]


def set_up(root: Path) -> Path:
    """The folder of the environment's programs; makes the environment, installs the project and compiles the kernel where needed."""
    place = root / ".venv"
    scripts = place / ("Scripts" if os.name == "nt" else "bin")
    python = scripts / ("python.exe" if os.name == "nt" else "python")
    if not python.exists():
        make_environment(place)
    check_environment(python)
    stamp = place / "evat-installed"
    state = _installed_state(root)
    if not stamp.is_file() or stamp.read_text(encoding="ascii") != state:
        stamp.unlink(missing_ok=True)
        install(python, root, f"{root}[{EXTRAS}]")
        stamp.write_text(state, encoding="ascii")
    if step("compile the kernel where its sources changed", [str(python), "-m", "evat.native.compile"]):
        raise SetupError("The kernel does not compile; the compiler's message stands above.")
    return scripts


def make_environment(place: Path) -> None:
    if importlib.util.find_spec("venv") is None or importlib.util.find_spec("ensurepip") is None:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise SetupError(
            f"{sys.executable} cannot make a private environment: its module venv or ensurepip is missing.\n"
            f"Debian and Ubuntu package them apart: sudo apt install python{version}-venv. Then run this again."
        )
    if step(f"make the private environment {place.name}", [sys.executable, "-m", "venv", str(place)]):
        raise SetupError(f"{place} could not be made; the message stands above. Remove what there is of it and run this again.")


def check_environment(python: Path) -> None:
    """An environment may be older than this run: its Python must start, be new enough and have pip."""
    ask = "import sys; print(int(sys.version_info >= (3, 10)))"
    try:
        answer = subprocess.run([str(python), "-c", ask], capture_output=True, text=True, check=False).stdout.strip()
    except OSError:
        answer = ""
    if answer != "1":
        fault = "is older than 3.10" if answer == "0" else "does not start"
        raise SetupError(f"The Python of the environment {python.parent.parent} {fault}. Remove that folder and run this again.")
    pip_works = subprocess.run([str(python), "-m", "pip", "--version"], capture_output=True, check=False).returncode == 0
    if not pip_works and step("put pip into the environment", [str(python), "-m", "ensurepip", "--upgrade"]):
        raise SetupError(f"pip is missing in {python.parent.parent}. Remove that folder and run this again.")


def install(python: Path, root: Path, what: str) -> None:
    """Install `what` as editable: by uv, which needs a tenth of the time of pip, else by pip, whose words of a registry out of reach
    are known here."""
    say("install the project and its tools (minutes at first: a C compiler is among them)")
    pip = [str(python), "-m", "pip", "install", "--disable-pip-version-check"]
    with_uv = [str(python), "-m", "uv", "pip", "install", "--python", str(python), "-e", what]
    if subprocess.run([*pip, "--quiet", "uv>=0.5"], cwd=root, capture_output=True, check=False).returncode == 0:
        if subprocess.run(with_uv, cwd=root, env={**uv_settings(python), **os.environ}, check=False).returncode == 0:
            return
        say("uv could not install it, for the reason above; pip tries")
    complaints: list[str] = []
    with subprocess.Popen([*pip, "-e", what], cwd=root, stderr=subprocess.PIPE, text=True, errors="replace") as process:
        for line in process.stderr or ():
            sys.stderr.write(line)
            complaints.append(line)
    if process.returncode == 0:
        return
    if any(sign in line for line in complaints for sign in UNREACHABLE):
        raise SetupError(
            "The package registry could not be reached, so the project is not installed. Check the network, or name a mirror or a folder\n"
            "of wheels (PIP_INDEX_URL, PIP_FIND_LINKS, or pip's own settings), then run this again; what is done is kept."
        )
    raise SetupError(f"pip could not install the project (status {process.returncode}); its first ERROR line above says why.")


def uv_settings(python: Path) -> dict[str, str]:
    """pip's settings as the environment variables of uv, which reads none of pip's: of two settings of one name the later in pip's list
    holds, which is that of its environment variables."""
    command = [str(python), "-m", "pip", "config", "list"]
    listed = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False).stdout
    pip: dict[str, str] = {}
    for line in sorted(listed.splitlines(), key=lambda line: line.startswith(":env:")):
        name, equals, value = line.partition("=")
        if equals and (said := str(ast.literal_eval(value))):
            pip[name.rpartition(".")[2].removeprefix("default-")] = said
    # As pip does, the newest of a package is taken wherever it stands.
    settings = {"UV_INDEX_STRATEGY": "unsafe-best-match"}
    for name, variable, separator in UV_VARIABLES:
        if words := pip.get(name, "").split():
            settings[variable] = separator.join(words)
    return settings


def step(title: str, command: Sequence[str], unless_set: Mapping[str, str] | None = None) -> int:
    """Say what begins, run a program with its output on the screen, with variables of the environment that are not set; its status.

    Python keeps the modules that it compiles, even where the environment forbids it: the tests start hundreds of processes, and to
    compile numpy, scipy and ours anew takes each longer than what it is started for.
    """
    say(title)
    environment = {**(unless_set or {}), **os.environ}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    try:
        return subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode
    except OSError as error:
        print(f"{command[0]}: {error.strerror}", file=sys.stderr)
        return 127


def say(text: str) -> None:
    print(f"[{time.strftime('%H:%M:%S')}] {text}", flush=True)


def _runs_alone(arguments: Sequence[str]) -> bool:
    """Benchmarks and debuggers need one process; a number of processes may be given already."""
    return any(word.startswith(("-n", "--numprocesses", "--benchmark-", "--pdb", "--dist", "tests/benchmarks")) for word in arguments)


def _installed_state(root: Path) -> str:
    """Changes when the project must be installed again: other requirements, another way to build, another place."""
    digest = hashlib.sha256(str(root).encode())
    for name in ("pyproject.toml", "build/hatch_build.py"):
        digest.update((root / name).read_bytes())
    return digest.hexdigest()
