"""Can sources of several of our FMUs be one program? Compiled as an importer compiles them, every name is the FMU's own."""

from __future__ import annotations

import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest
from evat import fmu
from evat.native.compile import CONTACT, fmi_headers
from fmpy.model_description import read_build_description

# The contact, the contact under another name, and a partner in both versions, with options of gcc, which sees more where it optimises. The
# campaign adds the contact's other version, and optimises all. It says nothing of the kernel as the tests under sanitizers compile it.
OPTIMISED = ("-O2", "-Wstringop-overflow=4")
TOGETHER: dict[tuple[str, int], tuple[str, ...]] = {
    (CONTACT, 2): OPTIMISED,
    ("evat_guideway", 3): (),
    ("spindle", 2): (),
    ("spindle", 3): (),
}
EITHER = [
    pytest.param(TOGETHER, id="plain"),
    pytest.param(dict.fromkeys([*TOGETHER, (CONTACT, 3)], OPTIMISED), id="optimised", marks=pytest.mark.campaign),
]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not (shutil.which("gcc") and shutil.which("nm")), reason="gcc and nm are not on this machine"),
]


def run(*command: str | Path) -> str:
    result = subprocess.run([*map(str, command)], capture_output=True, text=True, errors="replace", check=False)
    assert result.returncode == 0, result.stderr[-3000:]
    assert "warning" not in result.stderr, result.stderr[:3000]
    return result.stdout


@pytest.fixture(scope="module")
def headers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The standard's headers. In that of FMI 2 fmpy has left out what FMI2_FUNCTION_PREFIX does; here it stands as the standard has it."""
    folder = tmp_path_factory.mktemp("headers")
    shutil.copytree(fmi_headers(), folder, dirs_exist_ok=True)
    whole, plain = folder / "fmi2Functions.h", "#define fmi2FullName(name) name"
    text = whole.read_text(encoding="latin-1")
    assert text.count(plain) == 1
    prefixed = (
        "#if defined(FMI2_FUNCTION_PREFIX)\n#define fmi2Paste(a,b) a ## b\n#define fmi2PasteB(a,b) fmi2Paste(a,b)\n"
        f"#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)\n#else\n{plain}\n#endif"
    )
    whole.write_text(text.replace(plain, prefixed), encoding="latin-1")
    return folder


@pytest.fixture(scope="module", params=EITHER)
def objects(
    request: pytest.FixtureRequest, fmus: dict[str, Path], headers: Path, tmp_path_factory: pytest.TempPathFactory
) -> dict[tuple[str, int], Path]:
    """Each FMU's listed sources in one relocatable object, compiled by gcc with no option but warnings and FMI's own prefix."""
    made = {}
    for (part, version), options in request.param.items():
        folder = tmp_path_factory.mktemp(f"{part}_{version}")
        with zipfile.ZipFile(fmus[f"fmi{version}" if part == CONTACT else f"{part}-fmi{version}"]) as archive:
            archive.extractall(folder)
        configuration = read_build_description(str(folder))[0]
        prefix = f"-DFMI{version}_FUNCTION_PREFIX={fmu.fmu_facts_of(part).model_name}_"
        compiled = []
        for place, name in enumerate(configuration.sourceFileSets[0].sourceFiles):
            compiled.append(folder / f"{place}.o")
            run("gcc", "-std=c99", *options, "-Wall", "-Wextra", "-c", prefix, f"-I{headers}",
                *(f"-I{folder / 'sources' / include}" for include in configuration.sourceFileSets[0].includeDirectories),
                folder / "sources" / name, "-o", compiled[-1])  # fmt: skip
        made[part, version] = folder / "whole.o"
        run("gcc", "-r", "-nostdlib", *compiled, "-o", made[part, version])
    return made


def test_every_external_name_begins_with_the_model(objects: dict[tuple[str, int], Path]) -> None:
    """A name such as warn would be glibc's warn(3) to whoever links without hidden visibility."""
    for (part, _), whole in objects.items():
        names = re.findall(r"^\S+ [A-Z] (\w+)$", run("nm", "--extern-only", "--defined-only", whole), re.MULTILINE)
        assert len(names) > 80
        front = fmu.fmu_facts_of(part).model_name + "_"
        assert [name for name in names if not name.startswith(front)] == []


def test_several_fmus_are_one_program(objects: dict[tuple[str, int], Path], tmp_path: Path) -> None:
    versions = {key: f"{fmu.fmu_facts_of(key[0]).model_name}_fmi{key[1]}GetVersion" for key in objects}
    program = tmp_path / "host.c"
    program.write_text(
        "#include <stdio.h>\n"
        + "".join(f"const char *{name}(void);\n" for name in versions.values())
        + "int main(void)\n{\n"
        + "".join(f"    puts({name}());\n" for name in versions.values())
        + "    return 0;\n}\n"
    )
    run("gcc", program, *objects.values(), "-lm", "-o", tmp_path / "host")
    assert run(tmp_path / "host").split() == [f"{version}.0" for _, version in objects]
