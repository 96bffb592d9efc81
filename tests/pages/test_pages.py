"""No page states a result by hand, and every released result is of today's kernels."""

import re
import subprocess
from pathlib import Path

import pytest
import yaml
from project import ROOT, needs_study
from workflows import run

from docs import write_pages
from docs.data.kernels import digest

import findings  # isort: skip - beside what write_pages has put on the path

DOCS = ROOT / "docs"
BUILT = "_build", "_generated", "jupyter_execute", "data"
PAGES = sorted(path for path in DOCS.rglob("*.md") if path.relative_to(DOCS).parts[0] not in BUILT)
PAGES += [ROOT / "README.md", *sorted(ROOT.glob("studies/*/README.md"))]
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


# pages quote the findings of all studies
whole = needs_study(
    *(path.parent.name for path in write_pages.TEMPLATES if "studies" in path.parts)
)
RELEASED = [file for file in findings.FILES if file.path.is_file()]
MEASURED = [file for file in findings.MEASURED if file.path.is_file()]


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


LINK = re.compile(r"\]\(([^)#\s]*)[^)\s]*\)")


@whole
@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_a_page_states_no_result_by_hand_and_leads_somewhere(page):
    """It is its template filled in, by `python docs/write_pages.py`; a number that no run made is listed as
    `given`, with the reason. An interval from zero to zero is said in words. Links lead to what is in a checkout
    and no template; what the build makes is linked by a role or shown by a directive."""
    text, template = page.read_text(encoding="utf-8"), page.with_suffix(".md.in")
    written = template if template.exists() else page
    assert results_typed(written.read_text(encoding="utf-8")) == ([], [])
    if written is template:
        assert template in write_pages.TEMPLATES and text == write_pages.text_of(template)
    assert not re.findall(r"\{\{|\{%", re.sub(r"^(`{3,}).*?^\1`*\s*$", "", text, flags=re.S | re.M))
    assert not re.findall(r"\b0(?:\.0+)?\s\(0(?:\.0+)? to 0(?:\.0+)?\)", text)
    links = [link for link in LINK.findall(text) if "://" not in link]
    assert [link for link in links if not (page.parent / link).exists()] == []
    assert [link for link in links if link.endswith(".in")] == []


def test_every_released_file_can_be_renewed_and_names_what_made_it():
    """docs/data holds nothing that no script writes."""
    paths = {file.path for file in (*findings.FILES, *findings.MEASURED)}
    assert {*DOCS.glob("data/*.nc")} <= paths
    for file in RELEASED:
        assert file.dataset.attrs["made_with"] == file.command
        revisions = file.dataset.attrs["git_revision"]
        assert re.fullmatch(r"[0-9a-f]{7,}(; [0-9a-f]{7,})*", revisions), file.name


def by_hand():
    """Files of numbers beside the pages and in the studies that release.py does not copy: by name, one hash
    of the kernels, or one for each entry."""
    for path in sorted((*DOCS.glob("data/*"), *ROOT.glob("studies/*/*"))):
        if path.suffix in (".yaml", ".json") and path.name != "unchanged.yaml":
            values = yaml.safe_load(path.read_text(encoding="utf-8"))
            if not {"sweep", "extends", "cases"} & values.keys():
                yield path.name, values.get("kernels")


HASHES = {file.name: file.dataset.attrs["kernels"] for file in [*RELEASED, *MEASURED]}
HASHES |= by_hand()
UNCHANGED = yaml.safe_load((DOCS / "data/unchanged.yaml").read_text(encoding="utf-8"))


@pytest.mark.skipif(not (ROOT / ".git").exists(), reason="a copy without git")
def test_only_the_four_files_that_figures_need_are_larger_than_a_mebibyte():
    """Those that docs/data/README.md names; what is committed by mistake stays in each clone for ever."""
    text = (DOCS / "data/README.md").read_text(encoding="utf-8")
    (named,) = re.findall(r"^Figures need.*?Keep all others smaller", text, re.S | re.M)
    tracked = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    files = filter(Path.is_file, map(ROOT.joinpath, tracked.stdout.splitlines()))
    assert {path.name for path in files if path.stat().st_size > 2**20} == set(
        re.findall(r"`(\w+\.nc)`", named)
    )


@pytest.mark.parametrize("name", HASHES)
def test_numbers_are_of_todays_kernels(name):
    """Or docs/data/unchanged.yaml, about the code of today, says why they hold for it. What is written by hand
    has what `python docs/data/kernels.py` prints."""
    hashes = HASHES[name].values() if isinstance(HASHES[name], dict) else [HASHES[name]]
    reasons = [reason["why"] for reason in UNCHANGED["reasons"] if name in reason.get("of", [name])]
    argued = UNCHANGED["kernels"] == digest() and reasons and all(reasons)
    commands = [f" by `{file.command}`" for file in [*RELEASED, *MEASURED] if file.name == name]
    assert {*hashes} == {digest()} or argued, (
        f"{name} is stale: the code that decides how granules move has changed. Make it again"
        f"{''.join(commands)} as docs/data/README.md says, or say in unchanged.yaml why its numbers stay."
    )


@whole
def test_the_page_of_results_leads_to_each_page():
    text = (DOCS / "results/index.md").read_text(encoding="utf-8")
    pages = [f"{path.stem}.md" for path in DOCS.glob("results/*.md") if path.stem != "index"]
    pages += [
        f"../../studies/{path.parent.name}/README.md" for path in ROOT.glob("studies/*/README.md")
    ]
    assert [page for page in pages if f"]({page}) " not in text] == []


@whole
@pytest.mark.parametrize("path", write_pages.pictures(), ids=lambda path: path.stem)
def test_a_picture_is_of_the_released_file_and_of_its_code(path):
    """Draw them by `python docs/write_pages.py`. None weighs more than a checkout should carry."""
    assert write_pages.note_of(path) == write_pages.origin_of(write_pages.pictures()[path])
    is_film = path.suffix == ".gif"
    assert path.stat().st_size <= (write_pages.LARGEST_FILM if is_film else write_pages.LARGEST)


def test_a_sentence_that_the_data_contradicts_ends_the_build():
    with pytest.raises(ValueError, match="contradict the sentence 'Discs drag less"):
        findings.fill("{{ holds('Discs drag less than ellipses', drag.falls('e1', 'c1')) }}")


def test_the_messages_of_the_page_of_faults_are_those_of_the_package():
    """A value in them is printed as …; a sentence goes on in the next line of the code."""
    code = "".join(path.read_text(encoding="utf-8") for path in ROOT.glob("dem/**/*.py"))
    printed = re.sub(r"\{+.*?\}+", "…", re.sub(r'"\s+f?"', "", code))
    text = (DOCS / "howto/recovery.md").read_text(encoding="utf-8")
    table = text.partition("## What does the message mean?")[2].partition("\n## ")[0]
    messages = re.findall(r"^\| `(.*?)` \|", table, re.M)
    assert len(messages) > 5 and [words for words in messages if words not in printed] == []


def test_the_ways_of_two_numbers_lead_from_a_file_to_the_kernel_and_back(tmp_path):
    there, back = run(DOCS / "data/ways.py", cwd=tmp_path).split("force of a bin")
    assert "base/yaml_file.py: read\n" in there
    assert "dynamics/assembly.py: pair_constants\n" in there
    assert "observables/drag.py: measure\n" in back


@pytest.mark.parametrize("name", ["ensembles", "large_beds", "overhead"])
def test_scripts_that_take_too_long_to_be_run_begin(name, tmp_path):
    """All that they import is there."""
    assert "--help" in run(DOCS / f"data/{name}.py", "--help", cwd=tmp_path)
