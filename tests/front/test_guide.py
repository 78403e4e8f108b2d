"""Is the guide true, and does it read without a network? Every block of its pages and of the README is run, page by page."""

from __future__ import annotations

import base64
import contextlib
import doctest
import html
import io
import json
import re
import shlex
import statistics
import sys
from dataclasses import dataclass
from pathlib import Path

import evat
import fmpy
import fmpy.util
import pytest
from evat import guide
from evat.commands.main import main
from evat.constants import CONSTANTS
from evat.experiment.keys import TABLES
from evat.files.read_toml import read_toml
from evat.guide import notebooks, seal, tables
from evat.models import reference
from evat.native import kernel
from evat.native.compile import source_root
from evat.systems.ssp.write import write_all

README = Path(__file__).resolve().parents[2] / "README.md"
PAGES = {path.name: path for path in (*sorted(guide.pages().glob("*.md")), README)}
BLOCK = re.compile(
    r"(?:^<!-- not run: (?P<reason>[^\n]+) -->\n)?^(?P<fence>`{3,4})(?P<kind>\w*)\n(?P<text>.*?)^(?P=fence)$", re.DOTALL | re.MULTILINE
)
PRINTED = notebooks.PRINTED
CAMPAIGN = "seven seconds; the campaign runs it"
# What is not run, and why: longer than these tests may take, or in need of what they have not.
NOT_RUN = {
    "README.md": [
        "makes an environment and builds for five platforms, which takes minutes",
        "it takes ten seconds; the guide's page on measuring runs the same",
    ],
    "believe.md": ["takes a minute"],
    "notebook-rig.md": [CAMPAIGN],
    "contributing.md": ["sets up an environment and runs every test", "the tests build the guide by themselves"],
    "extend.md": ["build/test.py compiles by itself, which takes a minute"],
    "first-run.md": [
        "makes an environment of its own and builds for five platforms, which takes minutes; build/test.py itself is how the tests are run",
        "installs packages",
        "the compiler takes minutes, and fmpy opens a window",
    ],
    "machine.md": ["minutes; emps also needs a file with a reference motion"],
    "measure.md": [
        "a full search takes minutes",
        "five sets and six motions take a minute, real fits many",
        "the record is public but no part of this repository",
    ],
}
SHOWN_ONLY = ("", "toml", "c", "diff")  # kinds of block that are not programs


@dataclass(frozen=True)
class Block:
    """One fenced block of a page; `reason` says why it is not run."""

    kind: str
    text: str
    reason: str | None


def blocks(page: Path) -> list[Block]:
    return [Block(match["kind"], match["text"], match["reason"]) for match in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def agrees(expected: str, printed: str) -> bool:
    """As doctest compares: `...` stands for anything, runs of blanks are one."""
    return doctest.OutputChecker().check_output(expected, printed, doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE)


def run_python(block: Block, names: dict[str, object]) -> None:
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(block.text, "a block of the guide", "exec"), names)
    expected = [line[len(PRINTED) :] for line in block.text.splitlines() if line.startswith(PRINTED)]
    assert agrees("\n".join(expected) + "\n" * bool(expected), printed.getvalue()), printed.getvalue()


def commands(text: str) -> list[tuple[str, str]]:
    """Each command of a console block with what stands below it."""
    typed: list[list[str]] = []
    for line in text.replace("\\\n", " ").splitlines():
        if line.startswith("$ "):
            typed.append([line[2:]])
        else:
            typed[-1].append(line)
    return [(lines[0], "\n".join(lines[1:])) for lines in typed]


def run_console(block: Block, monkeypatch: pytest.MonkeyPatch) -> None:
    for command, expected in commands(block.text):
        words = shlex.split(command, comments=True)
        assert words[0] == "evat", f"{command}: say why it is not run"
        printed, complaints = io.StringIO(), io.StringIO()
        monkeypatch.setattr(sys, "argv", words)
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(complaints), pytest.raises(SystemExit) as end:
            main()  # in this process: a new one would load everything anew
        assert end.value.code in (None, 0), f"{command}: {complaints.getvalue()}"
        if expected.strip():
            assert agrees(expected + "\n", printed.getvalue()), f"{command} printed:\n{printed.getvalue()}"


LONG = [pytest.param(name, (None, CAMPAIGN), marks=pytest.mark.campaign) for name, reasons in NOT_RUN.items() if CAMPAIGN in reasons]


@pytest.mark.parametrize(("name", "reasons"), [*((name, (None,)) for name in PAGES), *LONG])
def test_every_block_of_a_page_runs(
    name: str, reasons: tuple[str | None, ...], tmp_path: Path, fmus: dict[str, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    todo = [block for block in blocks(PAGES[name]) if block.reason in reasons and block.kind not in SHOWN_ONLY]
    if any("fmus/" in block.text for block in todo):  # what `evat build --out fmus` would leave
        (tmp_path / "fmus").mkdir()
        for path in fmus.values():
            (tmp_path / "fmus" / path.name).symlink_to(path)
        write_all(tmp_path / "fmus", fmus["fmi2"].parent)
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": "__main__"}
    for block in todo:
        if block.kind == "python":
            run_python(block, names)
        else:
            assert block.kind == "console", f"a block of kind {block.kind!r} is neither run nor known to be no program"
            run_console(block, monkeypatch)


def test_what_is_not_run_is_listed_with_its_reason() -> None:
    reasons_of_page = {name: [block.reason for block in blocks(page) if block.reason is not None] for name, page in PAGES.items()}
    assert {name: reasons for name, reasons in reasons_of_page.items() if reasons} == NOT_RUN
    for name, page in PAGES.items():
        text = page.read_text(encoding="utf-8")
        assert text.count("<!-- not run:") - text.count("`<!-- not run:") == len(NOT_RUN.get(name, [])), f"{name}: a reason above no block"


@pytest.mark.parametrize("name", [name for name in PAGES if name.startswith(notebooks.PREFIX)])
def test_a_notebook_has_the_blocks_of_its_page(name: str) -> None:
    made = json.loads(notebooks.notebook(PAGES[name].read_text(encoding="utf-8"), PAGES[name].parent))
    code = ["".join(cell["source"]) for cell in made["cells"] if cell["cell_type"] == "code"]
    assert code == [block.text.strip() for block in blocks(PAGES[name])]
    text = "".join(line for cell in made["cells"] if cell["cell_type"] == "markdown" for line in cell["source"])
    assert ".md" not in text
    assert "<!--" not in text
    assert "```" not in text
    pytest.importorskip("nbformat").validate(made)


@pytest.mark.parametrize("name", [name for name in PAGES if name.startswith(notebooks.PREFIX)])
def test_a_notebook_shows_the_figure_of_each_block_that_makes_one(name: str) -> None:
    """build/pictures.py writes them; on the page each stands below its block, in the notebook it is the output of its cell."""
    page = PAGES[name].read_text(encoding="utf-8")
    parts = notebooks.BLOCK.split(page)
    drawing = [re.search(r"\.plot\([^\n]*\)$|\.savefig\(", code.strip()) is not None for code in parts[1::2]]
    below = [re.match(r"\s*!\[[^]]+\]\((pictures/[^)]+)\)", text) for text in parts[2::2]]
    assert [link is not None for link in below] == drawing
    assert any(drawing)
    pictures = [(PAGES[name].parent / link[1]).read_bytes() for link in below if link is not None]
    cells = [cell for cell in json.loads(notebooks.notebook(page, PAGES[name].parent))["cells"] if cell["cell_type"] == "code"]
    shown = [output["data"]["image/png"] for cell in cells for output in cell["outputs"] if output["output_type"] == "display_data"]
    assert [base64.b64decode(each) for each in shown] == pictures
    said = ["".join(output["text"]) for cell in cells for output in cell["outputs"] if output["output_type"] == "stream"]
    told = ["".join(f"{line[len(PRINTED) :]}\n" for line in code.splitlines() if line.startswith(PRINTED)) for code in parts[1::2]]
    assert said == [text for text in told if text and "..." not in text]


def test_notebooks_are_written_as_the_site_holds_them(site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["evat", "guide", "--notebooks", str(tmp_path / "mine")])
    with pytest.raises(SystemExit):
        main()
    written = {path.name: path.read_bytes() for path in (tmp_path / "mine").iterdir()}
    assert set(written) == {"fmu.ipynb", "paper.ipynb", "rig.ipynb", "machine.ipynb"}
    assert written == {path.name: path.read_bytes() for path in site.glob("*.ipynb")}
    for name in written:
        assert f'href="{name}"' in (site / f"notebook-{name}").with_suffix(".html").read_text(encoding="utf-8")


def test_the_experiment_that_is_shown_is_one(tmp_path: Path) -> None:
    """The only block of TOML: it is read with a data file that has its columns."""
    (block,) = [block for block in blocks(PAGES["measure.md"]) if block.kind == "toml"]
    (tmp_path / "trials").mkdir()
    (tmp_path / "experiment.toml").write_text(block.text, encoding="utf-8")
    (tmp_path / "trials" / "c1_a.csv").write_text("t [s],v,F\n0,0,0\n0.1,10,5\n0.2,20,6\n", encoding="utf-8")
    recorded = evat.read_experiment(tmp_path, evat.ContactModel())
    assert recorded.trials[0].inputs["slip_velocity"][1] == pytest.approx(0.01)
    assert recorded.nominal.relative_sd == {"F_C": 0.2}


def test_the_documents_of_the_page_on_the_format_are_whole(tmp_path: Path) -> None:
    """Each is read with data files that have the columns it names, written as it says."""
    shown = [block for block in blocks(PAGES["experiment-format.md"]) if block.kind == "toml"]
    assert len(shown) == 3
    for place, block in enumerate(shown):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / "experiment.toml").write_text(block.text, encoding="utf-8")
        told = read_toml(folder / "experiment.toml")
        form = {"delimiter": ",", "decimal": ".", "encoding": "utf-8", "rows_after_header": 0, **told.get("reader", {})}
        columns = [signal["column"] for signal in told["signals"].values()] + told.get("means", {}).get("ignore", [])
        rows = [columns, *[["-"] * len(columns)] * form["rows_after_header"]]
        rows += [[f"{row + 1.5}".replace(".", form["decimal"])] * len(columns) for row in range(5)]
        for entry in [*told.get("trials", []), *([told["means"]] if "means" in told else [])]:
            text = "\n".join(form["delimiter"].join(row) for row in rows)
            (folder / entry["file"]).write_text(text, encoding=form["encoding"])
        recorded = evat.read_experiment(folder, evat.ContactModel())
        assert recorded.samples > 0
        assert len(recorded.trials) == len(told.get("trials", []))


def test_the_table_of_keys_is_the_one_that_documents_are_checked_by(site: Path) -> None:
    page = (site / "experiment-format.html").read_text(encoding="utf-8").replace("&#95;", "_")
    for keys in TABLES.values():
        for key in keys:
            assert f'<code class="name">{key.name}</code>' in page
            assert html.escape(key.meaning, quote=False) in page.replace("&quot;", '"'), key.name


def test_the_readme_is_short_and_uses_the_front_door_alone() -> None:
    text = README.read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 100
    for block in blocks(README):
        if block.kind == "python":
            assert not re.findall(r"^\s*from evat\b|^\s*import evat\.", block.text, flags=re.MULTILINE), block.text
            assert set(re.findall(r"\bevat\.(\w+)", block.text)) <= set(evat.__all__)


@pytest.mark.parametrize("name", PAGES)
def test_every_file_that_a_page_names_is_there(name: str) -> None:
    text = PAGES[name].read_text(encoding="utf-8")
    root = README.parent
    for path in re.findall(r"`((?:fmu_src|build|tests|ssp)/[\w./-]+)`", text):
        assert (root / path).exists(), f"{name} names {path}"
    for target in re.findall(r"\]\((?!https:)([^)#]+)", text):
        assert (PAGES[name].parent / target).exists(), f"{name} links to {target}"


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return guide.build(tmp_path_factory.mktemp("guide") / "site").parent


def test_the_site_is_built_without_a_warning_and_asks_no_network(site: Path) -> None:
    """mkdocs is strict: a dead link or an unknown name would have stopped it. Pictures, styles and scripts all lie beside the pages."""
    pages = sorted(site.rglob("*.html"))
    assert {path.with_suffix(".html").name for path in PAGES.values()} - {"README.html"} <= {page.name for page in pages}
    for page in pages:
        text = page.read_text(encoding="utf-8")
        for tag in re.findall(r"<(?:script|link|img|iframe|source)\b[^>]*>", text):
            assert not re.search(r"(?:src|href)=[\"']?(?:https?:)?//", tag), f"{page.name}: {tag}"
            if link := re.search(r"(?:src|href)=[\"']?([^\"'>\s]+)", tag):
                assert link[1].startswith("data:") or (page.parent / link[1].partition("?")[0].partition("#")[0]).exists(), tag
        assert "<!-- table:" not in text, page.name
        assert "<!-- include:" not in text, page.name


def test_the_table_of_constants_is_the_one_they_are_taken_from(site: Path) -> None:
    page = (site / "constants.html").read_text(encoding="utf-8").replace("&#95;", "_")
    for name, each in CONSTANTS.declared().items():
        assert f'<code class="name">{name}</code>' in page
        assert html.escape(each.meaning, quote=False) in page, name


def test_the_table_of_constants_says_which_are_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that was measured at another value than it has now is not."""
    change = {"log_loss": 0.25, "right": -1, "changed": 2, "failed": 0}
    rows = {
        "bands": {"value": CONSTANTS.bands, "cases": [0, 1, 2], "read_in": 2, "halved": change, "doubled": change},
        "fmu_samples": {"value": CONSTANTS.fmu_samples, "cases": [0, 1, 2], "read_in": 0, "halved": change, "doubled": change},
        "most_lags": {"value": CONSTANTS.most_lags + 1, "cases": [0, 1, 2], "read_in": 2, "halved": change, "doubled": change},
    }
    monkeypatch.setattr(tables.sensitivity, "read", lambda: {"made": {}, "constants": rows})
    text = tables.TABLES["constants"]()
    names = ("bands", "most&#95;lags", "fmu&#95;samples")
    bands, lags, unread = (next(line for line in text.splitlines() if f">{name}<" in line) for name in names)
    assert bands.endswith("| 2 | +0.250 (-1, 2) | +0.250 (-1, 2) |")
    assert lags.endswith("| 0 | not yet | not yet |")
    assert unread.endswith("| 0 | not read | not read |")
    count = len(CONSTANTS.declared())
    assert f"Measured: 2 of {count} constants, 1 of which no case that was run reads; {count - 2} not yet." in text


def test_the_origin_of_all_constants_is_counted() -> None:
    """By the same table that the page shows, on both pages that speak of it."""
    origins = [each.origin for each in CONSTANTS.declared().values()]
    words = re.findall(r"\d+", tables.TABLES["origin of constants"]())
    assert [int(word) for word in words if word != words[2]] == [
        len(origins),
        *(origins.count(one) for one in ("guess", "calibrated", "derived")),
    ]
    assert 0 < int(words[2]) < origins.count("guess")
    for name in ("constants.md", "diagnosis.md"):
        assert "<!-- table: origin of constants -->" in PAGES[name].read_text(encoding="utf-8")


def test_the_totals_of_the_diagnosis_are_those_of_its_test_sets() -> None:
    """The guide's figures of all test sets and of the sixteenth are those of tests/gap/second_reality/README.md."""
    text = (README.parent / "tests" / "gap" / "second_reality" / "README.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if re.match(r"\| [\w-]+ \(\d+\) \|", line)]

    def shares(cell: str) -> list[tuple[int, int]]:
        return [(round(float(share) * int(count)), int(count)) for share, count in re.findall(r"([\d.]+) \((\d+)\)", cell)]

    def of_all(pairs: list[tuple[int, int]]) -> str:
        return f"{sum(one for one, _ in pairs)} of {sum(count for _, count in pairs)}"

    assert len(rows) == 33
    right, other = ([shares(row[1])[form] for row in rows] for form in (0, 1))
    falsely, unknown = ([pair for row in some for pair in shares(row[k])] for some, k in ((rows[2:], 3), (rows, 4)))
    page = " ".join(PAGES["diagnosis.md"].read_text(encoding="utf-8").split())
    assert (
        f"thirty-three test sets {of_all(right)} single effects were named where the base law has the right form, and {of_all(other)} where"
        in page
    )
    assert f"where there is none in {of_all(falsely)} cases of the last thirty-one" in page
    assert f"and {of_all(unknown)} causes that are not in the library" in page
    (sixteenth,) = [row for row in rows if row[0] == "sixteenth (2101)"]
    ((one, n), (two, m)) = [(share, count) for share, count in re.findall(r"([\d.]+) \((\d+)\)", sixteenth[1])]
    assert re.search(rf"\| one effect, named \| {one} \[[^]]+\] \({n}\) \| {two} \[[^]]+\] \({m}\) \|", page)
    closed = [[float(share) for share in row[6].split(", ")] for row in rows[rows.index(sixteenth) + 1 :]]
    medians = " and ".join(f"{statistics.median(form):.2f}" for form in zip(*closed, strict=True))
    assert len(closed) == 17
    assert f"Of the seventeen sets after it, of which no case had been looked at, it is {medians} in the median" in page
    judged_alike = [row for row in rows if row[0].startswith(("fifteenth", "sixteenth"))]
    assert f"have {of_all([pair for row in judged_alike for pair in shares(row[1])])} single effects" in page
    assert f"{of_all([pair for row in judged_alike for pair in shares(row[3])]).replace(' of', ' false alarms in')}" in page


def test_the_page_tells_of_every_parameter_set() -> None:
    section = PAGES["first-run.md"].read_text(encoding="utf-8").split("## Which values for my material?")[1].split("\n## ")[0]
    named = re.findall(r"`([^`]+)`", "".join(line.split("|")[1] for line in section.splitlines() if line.startswith("| `")))
    assert sorted(named) == sorted(evat.parameter_sets.names())


def test_the_readme_shows_what_the_guide_finds() -> None:
    """Its diagnosis is not run: the command and the lines below it are those of the page on measuring, which is."""

    def diagnoses(page: Path) -> list[tuple[str, str]]:
        typed = [one for block in blocks(page) if block.kind == "console" for one in commands(block.text)]
        return [(command, printed) for command, printed in typed if command.startswith("evat diagnose other-rig ")]

    ((command, printed),), ((same, expected),) = diagnoses(README), diagnoses(PAGES["measure.md"])
    assert shlex.split(command, comments=True) == [word for word in shlex.split(same) if word not in ("--explain", "sensor_delay")]
    assert agrees(expected[: expected.index("...")] + "...", printed)


def test_the_page_lists_what_the_python_fmu_has() -> None:
    """Each law and effect of the twin, and of the laws that it refuses each by its name."""
    page = PAGES["fmu.md"].read_text(encoding="utf-8").split("## The Python FMU")[1].split("\n## ")[0]
    has, refused = page.split("Every other choice")
    assert set(re.findall(r"`(\w+)`", has)) == {*reference.LAWS, *reference.EFFECTS}
    assert set(re.findall(r"`(\w+)`", refused)) == {law.name for law in kernel.laws()} - set(reference.LAWS)


def test_the_accuracy_of_the_integrator_is_that_of_the_tabled_seeds() -> None:
    """The guide's figures of the latest seed and of all are those of tests/tolerance/README.md."""

    def count(text: str) -> int:
        return int(text.replace(" ", ""))

    def spaced(number: int) -> str:
        return f"{number:,}".replace(",", " ")

    text = (README.parent / "tests" / "tolerance" / "README.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if re.match(r"\| \d", line)]
    judged = [row for row in rows if row[2]]
    page = " ".join(
        PAGES["believe.md"].read_text(encoding="utf-8").split("### Accuracy of the integrator")[1].split("## Limits")[0].split()
    )
    *_, (seed, _, of, within_3, within_10, all_3, all_10, beyond, _) = rows
    assert f"Of the {of} contacts that are judged of the latest seed, {seed}," in page
    shares = f"| 3 tolerances | {within_3} | {all_3} | | 10 tolerances | {within_10} | {all_10} | | beyond 10 | "
    assert re.search(re.escape(shares) + ("none" if within_10 == "all" else r"\d+") + rf" \| {beyond} \|", page)
    drawn, beyond_10, counted = (sum(count(row[k]) for row in some) for some, k in ((rows, 1), (rows, 7), (judged, 2)))
    assert f"lists {len(rows)} seeds: {beyond_10} of {spaced(drawn)} contacts drawn" in page
    assert f"({len(judged)} seeds, {spaced(counted)} contacts judged)" in page
    friction, outputs = (min(row[k] for row in judged if row[k] != "all") for k in (3, 5))
    assert f"in {friction} or more of each seed, all outputs in {outputs} or more" in page


def test_the_tables_are_the_kernels(site: Path) -> None:
    effects = (site / "effects.html").read_text(encoding="utf-8")
    for effect in kernel.effects():
        assert f'id="{effect.name}"' in effects
        for variable in effect.variables:
            assert variable.name.replace("_", "&#95;") in effects or variable.name in effects
    for law in kernel.laws():
        assert f'<code class="name">{law.name}</code>' in effects.replace("&#95;", "_")
    listed = (site / "variables.html").read_text(encoding="utf-8").replace("&#95;", "_")
    for causality in ("input", "parameter", "output"):
        for variable in tables._of_the_contact(causality):
            assert f'<code class="name">{variable.name}</code>' in listed, variable.name
            for choice, number in variable.items.items():
                assert f'<code class="name">{choice}</code> ({number})' in listed, choice
    how_to = (source_root() / "kernel" / "effects" / "README.md").read_text(encoding="utf-8").splitlines()[0]
    assert how_to.removeprefix("# ") in (site / "add-an-effect.html").read_text(encoding="utf-8")


def test_the_guide_is_opened_or_says_how_it_is_built(
    site: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url) or True)
    monkeypatch.setattr(guide, "built_to", lambda: site)
    for words in (["evat", "guide"], ["evat", "guide", "--path"]):
        monkeypatch.setattr(sys, "argv", words)
        with pytest.raises(SystemExit):
            main()
    assert opened == [(site / "index.html").as_uri()]
    assert str(site / "index.html") in capsys.readouterr().out.replace("\n", "")
    monkeypatch.setattr(guide, "built_to", lambda: tmp_path / "nowhere")
    with pytest.raises(guide.GuideError, match="evat guide --build"):
        guide.first_page()


def test_a_folder_that_is_no_guide_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work", encoding="utf-8")
    with pytest.raises(guide.GuideError, match="no guide"):
        guide.check_place(tmp_path / "mine")
    assert (tmp_path / "mine" / "thesis.txt").read_text(encoding="utf-8") == "years of work"


def test_the_seal_sees_what_the_guide_is_made_from(tmp_path: Path) -> None:
    for part in ("guide", "kernel"):
        (tmp_path / part).mkdir()
    (tmp_path / "guide" / "index.md").write_text("a", encoding="utf-8")
    first = seal.digest(tmp_path)
    (tmp_path / "guide" / "__pycache__").mkdir()
    (tmp_path / "guide" / "__pycache__" / "x.py").write_text("", encoding="utf-8")
    assert seal.digest(tmp_path) == first
    (tmp_path / "kernel" / "lugre.c").write_text("b", encoding="utf-8")
    assert seal.digest(tmp_path) != first


def test_a_wheel_holds_the_site_if_it_is_of_these_sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("hatchling")
    monkeypatch.syspath_prepend(str(README.parent / "build"))
    import hatch_build

    own = tmp_path / "fmu_src" / "evat" / "guide"
    own.mkdir(parents=True)
    (own / "seal.py").write_bytes(Path(str(seal.__file__)).read_bytes())
    (tmp_path / "fmu_src" / "guide").mkdir()
    (tmp_path / "fmu_src" / "guide" / "index.md").write_text("a", encoding="utf-8")
    built = tmp_path / "build" / "out" / "guide"
    built.mkdir(parents=True)
    pages = {str(tmp_path / "fmu_src" / "guide"): "evat/_source/guide"}
    assert hatch_build.guide_included(tmp_path) == pages
    (built / seal.SEAL).write_text(seal.digest(tmp_path / "fmu_src"), encoding="ascii")
    assert hatch_build.guide_included(tmp_path) == {**pages, str(built): "evat/_guide"}
    (tmp_path / "fmu_src" / "guide" / "index.md").write_text("b", encoding="utf-8")
    assert hatch_build.guide_included(tmp_path) == pages


def test_what_the_guide_plots_with_fmpy_is_drawn_by_it(fmus: dict[str, Path]) -> None:
    """The window is not opened, the figure is made; of more than 17 signals fmpy makes none."""
    lines = re.findall(
        r"^\$ fmpy simulate fmus/(\S+) --show-plot(?: --output-variables (.*))?$", PAGES["first-run.md"].read_text("utf-8"), re.M
    )
    lines += re.findall(r"^\$ \S*fmpy simulate build/out/fmus/(\S+) --show-plot()$", README.read_text("utf-8"), re.M)
    by_name = {path.name: path for path in fmus.values()}
    assert len(lines) == 4
    for name, outputs in lines:
        result = fmpy.simulate_fmu(str(by_name[name]), output=outputs.split() or None)
        figure = fmpy.util.create_plotly_figure(result)
        assert len(figure.data) == len(result.dtype.names) - 1 > 2
        assert not outputs or {*outputs.split()} < set(result.dtype.names)
