"""No page states a result by hand, and every released result is of today's kernels."""

import ast
import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import textwrap

import pytest
import yaml
from project import needs_study, posix
from typer.testing import CliRunner

from dem.base.source_hash import ROOT
from dem.cli.app import app
from docs.data.kernels import digest

DOCS = ROOT / "docs"
BUILT = "_build", "_generated", "jupyter_execute", "data"
# as they are read, and as they are written: the template of a page instead of the page
PAGES = sorted(path for path in DOCS.rglob("*.md") if path.relative_to(DOCS).parts[0] not in BUILT)
PAGES += [ROOT / "README.md", *sorted(ROOT.glob("studies/*/README.md"))]
WRITTEN = [path if not (page := path.with_suffix(".md.in")).exists() else page for path in PAGES]
FRONT_MATTER = re.compile(r"\A---\n(.*?)\n---\n", re.S)
NO_PROSE = re.compile(
    r"^(?P<fence>`{3,}|~{3,})(?!\{(?!code)).*?^(?P=fence)[`~]*\s*$"  # code; {note} and the like are prose
    r"|`[^`\n]+`|\{\{.*?\}\}|\{%.*?%\}|\]\([^)\n]*\)|^:\w+:[^\n]*$",
    re.S | re.M,
)
UNITS = (
    r"[kMG]?Pa|[mk]N|[kM]?N/m|[mk]?m/s|ms|us|µs|μs|ns|min|minutes?|hours?|seconds?|days?|weeks?"
    r"|[µμmn]icroseconds?|milliseconds?|nanoseconds?|per ?cent|times"
)
RESULT = re.compile(
    r"(?:\d[\d.,]*\s*)?(?:±|\+-|\+/-|\\pm)\s*\d[\d.,]*"
    rf"|\d[\d.,]*(?:[ \u00a0\u202f-]?(?:{UNITS})|[ \u00a0\u202f-](?:N|s|h))\b"
    r"|\d[\d.,]*(?<!,)[ \u00a0\u202f]?%"
)


def load(path):
    """A script of docs as a module."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


release = load(DOCS / "data/release.py")
write = load(DOCS / "write_pages.py")
findings = sys.modules["findings"]
# pages quote the findings of all studies
whole = needs_study(*(path.parent.name for path in write.TEMPLATES if "studies" in path.parts))
RELEASED = [file for file in findings.FILES if file.path.is_file()]
MEASURED = [file for file in findings.MEASURED if file.path.is_file()]
# Numbers that no command copies: each has one hash of the kernels, or one for each entry.
KERNELS = {
    ".yaml": lambda path: yaml.safe_load(path.read_text(encoding="utf-8")).get("kernels"),
    ".json": lambda path: json.loads(path.read_text(encoding="utf-8")).get("kernels"),
}
NO_NUMBERS = {"sweep", "extends", "cases"}, {"unchanged.yaml"}  # keys of sweeps; edits of kernels


def results_typed(text):
    """Numbers with a unit of force, time or speed, per cent, "times" or ± in the prose of a page,
    but for the level of intervals and those that its front matter gives with a reason; and what it
    gives in vain, or without one."""
    matter = FRONT_MATTER.match(text)
    constants = (yaml.safe_load(matter[1]) or {}).get("given", {}) if matter else {}
    prose = NO_PROSE.sub(" ", text[matter.end() :] if matter else text)
    vain = [number for number, reason in constants.items() if number not in prose or not reason]
    for number in sorted((*constants, "95 %"), key=len, reverse=True):
        prose = re.sub(rf"(?<![\d.,]){re.escape(number)}", " ", prose)
    return RESULT.findall(prose), vain


@pytest.mark.parametrize("page", WRITTEN, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_page_types_a_result(page):
    """Take the number from docs/_ext/findings; if no run made it, list it as `given`, with the
    reason."""
    assert results_typed(page.read_text(encoding="utf-8")) == ([], [])


@pytest.mark.parametrize("file", RELEASED, ids=lambda file: file.name)
def test_a_released_file_names_what_made_it(file):
    attrs = file.dataset.attrs
    assert attrs["made_with"] == file.command
    assert re.fullmatch(r"[0-9a-f]{7,}(; [0-9a-f]{7,})*", attrs["git_revision"])


def by_hand():
    """The files of numbers beside the pages and in the studies that release.py does not copy."""
    for path in sorted((*DOCS.glob("data/*"), *ROOT.glob("studies/*/*"))):
        if path.suffix in KERNELS and path.name not in NO_NUMBERS[1]:
            text = path.read_text(encoding="utf-8") if path.suffix == ".yaml" else "{}"
            if not NO_NUMBERS[0] & set(yaml.safe_load(text)):
                yield path


UNCHANGED = yaml.safe_load((DOCS / "data/unchanged.yaml").read_text(encoding="utf-8"))
ARGUED = UNCHANGED["kernels"] == digest()  # whether it is about the code of today


def holds(name, *hashes):
    """Whether the code of today made the numbers of a file, or docs/data/unchanged.yaml says why they hold for it."""
    reasons = [reason["why"] for reason in UNCHANGED["reasons"] if name in reason.get("of", [name])]
    return {*hashes} == {digest()} or (ARGUED and all(reasons) and reasons)


@pytest.mark.parametrize("path", list(by_hand()), ids=lambda path: path.name)
def test_numbers_written_by_hand_are_of_todays_kernels(path):
    """What is written by hand has what `python docs/data/kernels.py` prints."""
    digests = KERNELS[path.suffix](path)
    hashes = digests.values() if isinstance(digests, dict) else [digests]
    assert holds(path.name, *hashes), (
        f"{path.name} is stale; docs/data/README.md says how it is made."
    )


@pytest.mark.parametrize("file", [*RELEASED, *MEASURED], ids=lambda file: file.name)
def test_a_released_file_is_of_todays_kernels(file):
    assert holds(file.name, file.dataset.attrs["kernels"]), (
        f"{file.place} is stale: the code that decides how granules move has changed since {file.revision}. "
        f"Run `{file.command}`, then `python docs/data/release.py results`; or say in "
        "docs/data/unchanged.yaml why its numbers stay."
    )


def test_every_released_file_can_be_renewed():
    """docs/data holds nothing that no script writes."""
    paths = {file.path.name for file in (*findings.FILES, *findings.MEASURED)}
    assert {path.name for path in (DOCS / "data").glob("*.nc")} <= paths


def test_timings_name_what_made_them():
    about = findings.NAMES["timings"]
    assert re.fullmatch(r"[0-9a-f]{7,}", str(about["revision"]))
    assert about["date"] and about["machine"]
    assert all({"what", "command", "seconds"} == set(timing) for timing in about["timed"].values())


LINK = re.compile(r"\]\(([^)#\s]*)[^)\s]*\)")


@whole
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_the_links_of_a_page_lead_somewhere_in_a_checkout(page):
    """To no template, either. What the build makes is linked by a role ({doc}`...`) or shown by a
    directive."""
    links = [link for link in LINK.findall(page.read_text(encoding="utf-8")) if "://" not in link]
    assert [link for link in links if not (page.parent / link).exists()] == []
    assert [link for link in links if link.endswith(".in")] == []


@whole
def test_the_page_of_results_and_its_bar_name_each_page():
    folder, bar = DOCS / "results", (DOCS / "_ext/pages.py").read_text(encoding="utf-8")
    text = (folder / "index.md").read_text(encoding="utf-8")
    for page in {path.stem for path in folder.glob("*.md")} - {"index"}:
        assert f"]({page}.md) " in text and f"<{page}>" in bar
    for page in ROOT.glob("studies/*/README.md"):
        assert f"](../../studies/{page.parent.name}/README.md) " in text
        assert f"<../_generated/studies/{page.parent.name}>" in bar


@whole
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_table_gives_an_interval_of_nothing(page):
    """An interval from zero to zero is said in words."""
    text = page.read_text(encoding="utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert not re.findall(r"\b0(?:\.0+)? \(0(?:\.0+)? to 0(?:\.0+)?\)", text)


FILE = re.compile(r"^```(python|yaml|text)\n# (\S+\.(?:py|yaml|csv))\n(.*?)^```", re.S | re.M)
FRAGMENT = re.compile(r"^```yaml\n# (below|in place of) sweep\n(.*?)^```", re.S | re.M)
HOWTO = sorted((DOCS / "howto").glob("*.md"))


@pytest.fixture(scope="module")
def extended(tmp_path_factory):
    """A copy of package and configurations with the files of the how-to pages, and of nothing else."""
    folder = tmp_path_factory.mktemp("extended")
    for name in ("dem", "config"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    for page in HOWTO:
        for kind, name, block in FILE.findall(page.read_text(encoding="utf-8")):
            if kind == "python":
                (folder / name).write_text(block, encoding="utf-8")
    return folder


@pytest.mark.parametrize("page", HOWTO, ids=lambda path: path.stem)
def test_the_sweeps_of_a_page_can_be_run(extended, monkeypatch, page):
    """Whole files, named in their first line, and fragments, with where they belong."""
    text = page.read_text(encoding="utf-8")
    sweeps = {name: block for kind, name, block in FILE.findall(text) if kind == "yaml"}
    for n, (role, block) in enumerate(FRAGMENT.findall(text)):
        below = block if role == "in place of" else "sweep:\n" + textwrap.indent(block, "  ")
        if "shape:" not in below:
            below += "  shape: [c1]\n"
        sweeps[f"fragment{n}.yaml"] = f"extends: config/paper.yaml\nresults: results/f{n}\n{below}"
    assert len(sweeps) == text.count("```yaml\n")  # no piece that is neither
    data = {name: block for kind, name, block in FILE.findall(text) if kind == "text"}
    for name, content in (sweeps | data).items():
        (extended / name).write_text(content, encoding="utf-8")
    monkeypatch.chdir(extended)
    for name in sweeps:
        run = CliRunner().invoke(app, ["sweep", name, "--dry-run"])
        assert run.exit_code == 0, run.output


@posix
def test_a_figure_is_one_file(extended):
    """As its page has it. The experiment of the pages is swept in test_plugins.py."""
    words = "figure", "scatter", DOCS / "data/drag.nc", "-o", "drawn"
    run = subprocess.run(
        [sys.executable, "-P", "-m", "dem", *map(str, words)],
        cwd=extended,
        env=os.environ | {"PYTHONPATH": str(extended)},
        text=True,
        capture_output=True,
    )
    assert run.returncode == 0, run.stderr
    assert (extended / "drawn/scatter.svg").is_file()


@whole
@pytest.mark.parametrize("template", write.TEMPLATES, ids=lambda path: f"{path.relative_to(ROOT)}")
def test_a_page_is_its_template_filled_in(template):
    """Rewrite them by `python docs/write_pages.py`."""
    assert write.page_of(template).read_text(encoding="utf-8") == write.text_of(template)


@whole
@pytest.mark.parametrize("path", write.pictures(), ids=lambda path: path.stem)
def test_a_picture_is_of_the_released_file_and_of_its_code(path):
    """Draw them by `python docs/write_pages.py`. None weighs more than a checkout should carry."""
    assert write.note_of(path) == write.origin_of(write.pictures()[path])
    assert path.stat().st_size <= write.LARGEST


def test_no_picture_is_left_that_no_page_shows():
    pictures = {*DOCS.glob("images/*.png"), *ROOT.glob("studies/*/images/*")}
    assert pictures == set(write.pictures())


def test_a_sentence_that_the_data_contradicts_ends_the_build():
    with pytest.raises(ValueError, match="contradict the sentence 'Discs drag less"):
        findings.fill("{{ holds('Discs drag less than ellipses', drag.falls('e1', 'c1')) }}")


def sentences():
    """Texts of the package, a value in them as …, as messages are printed."""
    for path in ROOT.glob("dem/**/*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.JoinedStr):
                words = (
                    part.value if isinstance(part, ast.Constant) else "…" for part in node.values
                )
                yield re.sub(r"\{.*?\}", "…", "".join(words))  # also of what is filled in later
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield node.value


def test_the_messages_of_the_page_of_faults_are_those_of_the_package():
    text = (DOCS / "howto/recovery.md").read_text(encoding="utf-8")
    table = text.partition("## What does the message mean?")[2].partition("\n## ")[0]
    messages = re.findall(r"^\| `(.*?)` \|", table, re.M)
    printed = list(sentences())
    assert len(messages) > 5
    assert [message for message in messages if not any(message in words for words in printed)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_page_shows_a_place_for_a_number(page):
    """A template of Jinja that was not filled in."""
    prose = re.sub(r"^(`{3,}).*?^\1`*\s*$", "", page.read_text(encoding="utf-8"), flags=re.S | re.M)
    assert not re.findall(r"\{\{|\{%", prose)
