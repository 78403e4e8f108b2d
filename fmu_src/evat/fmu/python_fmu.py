"""How does reference.py become an FMU? pythonfmu packs it; what pythonfmu leaves out or gets wrong is put right here.

The package writes no units, no initial unknowns and no dependencies, a random GUID and times of the clock, and asks for an execution
tool. So its modelDescription.xml is replaced by the one that the native FMU's generator writes from the same tables, less what only a
native FMU can do, and the archive is packed anew: same input, same bytes.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
import subprocess
import sys
import uuid
import zipfile
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from lxml import etree

from evat import __version__, fmu
from evat.files.writing import put, temporary
from evat.fmu import archive, credibility
from evat.fmu.description import fmi2
from evat.fmu.description.model_description import FIRST_REFERENCE
from evat.fmu.documentation import picture
from evat.fmu.documentation.contact import license_text
from evat.fmu.fmu_facts import FmuFacts
from evat.fmu.part_model import shown_variables
from evat.html import render
from evat.model import FIRST_ITEM, BuildError
from evat.models import reference as reference_model
from evat.native import kernel

MODEL_NAME = "EvatContactPython"
PART = "evat_contact_python"  # by which evidence.toml calls it
HERE = Path(__file__).resolve().parent
SCRIPT, REFERENCE, TABLES = "evat_contact_python.py", "reference.py", "evat_contact_python.json"

_DEPENDENCIES = """Python 3.10 or newer, standard library only; nothing has to be installed into it.

The wrapper of pythonfmu (in binaries/, Linux x86_64 with glibc 2.32 or newer, and Windows x86_64) uses the Python of its process and
does not link libpython itself. A host that is a Python program (fmpy, PyFMI, ...) needs nothing more. Any other host must load libpython
before this FMU, on Linux for example with
    LD_PRELOAD=libpython3.11.so host ...
or it will refuse to load the FMU, or crash. The native FMU EvatContact has no such dependency.
"""


def tables() -> bytes:
    """The kernel's variable tables as the slave reads them; a number that is not finite is null."""
    rows = [dataclasses.asdict(variable) for variable in shown_variables(fmu.fmu_facts_of())]
    for row in rows:
        row.update({limit: row[limit] if math.isfinite(row[limit]) else None for limit in ("min", "max", "neutral")})
    content = {"first_item": FIRST_ITEM, "first_reference": FIRST_REFERENCE, "states": kernel.states(), "variables": rows}
    return json.dumps(content, indent=1, sort_keys=True, allow_nan=False).encode() + b"\n"


def _fmu_facts() -> FmuFacts:
    native = fmu.fmu_facts_of()
    flags = {
        "canHandleVariableCommunicationStepSize": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "canNotUseMemoryManagementFunctions": True,
        "needsExecutionTool": False,
    }
    return dataclasses.replace(
        native,
        model_name=MODEL_NAME,
        description=f"{native.description}; the same laws in plain Python",
        fmi2={"CoSimulation": flags},
        log_categories={name: text for name, text in native.log_categories.items() if name != "logEvents"},
    )


def model_description(token: str) -> bytes:
    """modelDescription.xml: the native FMU's, for co-simulation only."""
    facts = dataclasses.replace(fmu.facts(2), fmu=_fmu_facts(), token=token, sources=())
    top = etree.fromstring(fmi2.model_description(facts))
    del top.attrib["numberOfEventIndicators"]
    for sources in top.iterfind("CoSimulation/SourceFiles"):
        sources.getparent().remove(sources)
    for number in top.iterfind("ModelVariables/ScalarVariable/Real[@reinit]"):
        del number.attrib["reinit"]  # of model exchange
    etree.indent(top)
    return bytes(etree.tostring(top, xml_declaration=True, encoding="UTF-8", pretty_print=True))


def _page(token: str) -> bytes:
    fmu_facts, laws = _fmu_facts(), kernel.laws()
    text = render(
        "python_fmu.html.j2",
        fmu_facts=fmu_facts,
        version=__version__,
        day=archive.generated().date().isoformat(),
        token=token,
        laws=laws,
        variables=shown_variables(fmu.fmu_facts_of()),
        reference=REFERENCE,
        dependencies=_DEPENDENCIES,
        files={
            "externalDependencies.txt": "what it depends on",
            "licenses/license.txt": "the licence",
            "licenses/pythonfmu.txt": "the licence of pythonfmu, whose wrapper is in binaries/",
        },
    )
    return text.encode()


def _license_of_pythonfmu() -> bytes:
    for file in metadata.files("pythonfmu") or ():
        if file.name == "LICENSE":
            return file.read_text().encode()
    raise BuildError("the licence of pythonfmu is not among its installed files; install pythonfmu again.")


def _packed(sources: dict[str, bytes]) -> dict[str, bytes]:
    """What pythonfmu packs, file by file. In a process of its own, since it leaves the script imported."""
    with temporary() as folder:
        for name, content in sources.items():
            put(folder / name, content)
        others = [name for name in sources if name != SCRIPT]
        options = ["--no-external-tool", "--handle-state", "--serialize-state"]
        command: Sequence[str] = [sys.executable, "-B", "-m", "pythonfmu", "build", "-f", SCRIPT, *options, *others]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        made = folder / f"{MODEL_NAME}.fmu"
        if done.returncode != 0 or not made.is_file():
            reason = (done.stderr.strip() or done.stdout.strip() or f"exit status {done.returncode}").splitlines()[-1]
            raise BuildError(f"pythonfmu could not pack {SCRIPT}: {reason}. Correct the file that it names.")
        with zipfile.ZipFile(made) as packed:
            return {name: packed.read(name) for name in packed.namelist()}


def build_python_fmu(output: Path, reference: Path | None = None) -> Path:
    """Build the Python FMU and return its path.

    Parameters
    ----------
    output : the .fmu to write; it appears whole or not at all.
    reference : another reference.py to pack, with laws changed; the package's own by default.
    """
    source = Path(reference_model.__file__) if reference is None else reference
    try:
        laws = source.read_bytes()
    except OSError as error:
        raise BuildError(f"{source}: the laws cannot be read ({error.strerror}); give a Python file like {REFERENCE}.") from error
    sources = {SCRIPT: (HERE / SCRIPT).read_bytes(), REFERENCE: laws, TABLES: tables()}
    digest = hashlib.sha256(b"".join(hashlib.sha256(content).digest() for content in sources.values())).digest()
    token = f"{{{uuid.UUID(bytes=digest[:16])}}}"
    files = {
        **_packed(sources),
        "modelDescription.xml": model_description(token),
        "documentation/index.html": _page(token),
        "documentation/externalDependencies.txt": _DEPENDENCIES.encode(),
        "documentation/licenses/license.txt": license_text().encode(),
        "documentation/licenses/pythonfmu.txt": _license_of_pythonfmu(),
        "model.png": picture.diagram({variable.name for variable in shown_variables(fmu.fmu_facts_of())})[0].png,
        **credibility.credibility_files(MODEL_NAME, PART, token),
    }
    return archive.write(files, output)
