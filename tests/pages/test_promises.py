"""What code, pages and rules name is there and runs, found from them: no list to keep."""

import re
import runpy
import shlex
import shutil
import subprocess
import sys
import textwrap
import tomllib
import traceback
from contextlib import chdir, suppress
from inspect import cleandoc
from pathlib import Path

import matplotlib
import pytest
import workflows
import yaml
from command_line import called
from markdown_it import MarkdownIt
from project import ROOT, posix
from sweeps import of_file
from synthetic import plated, plates
from typer.main import get_command
from typer.testing import CliRunner

import dem
from dem.cli.app import app as dem_app
from dem.sweep.state import SweepState
from studies.__main__ import app as studies_app

sys.path.append(str(ROOT / "docs/_ext"))
import findings

# Who shows a command: pages but what the build writes, and the docstrings of rules, modules and verbs.
FOLDERS = "*.md", "docs/**/*.md", "studies/*/README.md", "dem/**/*.md"
BUILT = {"_build", "_generated", "jupyter_execute"}
PAGES = sorted(path for each in FOLDERS for path in ROOT.glob(each) if not BUILT & {*path.parts})
RULES = [ROOT / "Snakefile", *sorted(ROOT.glob("rules/*.smk"))]


def blocks(text):
    """Pieces of code in Markdown: language, empty where it is indented, and content."""
    for token in MarkdownIt().parse(text):
        if token.type in ("fence", "code_block"):
            yield token.info.strip(), token.content


def pieces(page, of):
    """What a page shows in a language."""
    text = page.read_text(encoding="utf-8")
    return [content for language, content in blocks(text) if language == of]


def lines():
    """Where a command is shown, and its line."""
    for path in PAGES:
        for language, content in blocks(path.read_text(encoding="utf-8")):
            if language in ("", "bash", "sh", "console"):
                sign = r"\$ " if language == "console" else ""
                yield from ((path, line) for line in re.findall(f"^{sign}(.*)", content, re.M))
    for path in (*RULES, *ROOT.glob("dem/**/*.py"), *ROOT.glob("studies/**/*.py")):
        for text in re.findall(r'"""(.*?)"""', path.read_text(encoding="utf-8"), re.S):
            text = cleandoc(text)
            shown = "\n".join(content for _, content in blocks(text))
            shown = re.sub(r"  +[a-z].*", "", shown)  # without words beside a command
            found = [*shown.splitlines(), *re.findall(r"Example: (.*)", text)]
            yield from ((path, line) for line in found)


def commands():
    """Each command that is shown, as words, and where it is shown first."""
    places = {}
    for path, line in lines():
        for part in re.split(r" && |; (?=\w+ )", line.strip()):
            with suppress(ValueError):  # no line of a shell
                words = tuple(shlex.split(part, comments=True))
                if words[:1] and words[0] in PROGRAMS:
                    places.setdefault(words, path)
    return places


PROGRAMS = "dem", "snakemake", "python", "make", "pip", "bash"
# What a command takes that a test cannot give, and what is left out then.
ENDLESS, ELSEWHERE = ("--watch",), ("--scheduler", "--wait")
NOT_RUN = {
    "python -m studies calibration fit": "its interval takes hundreds of runs; test_calibration.py has them",
    "python -m studies rft proof": "it reads the runs of sweeps; test_outlines.py has what it does",
    "python docs/data/release.py": "it writes the files of this checkout; test_pages.py reads it",
    "python docs/write_pages.py": "it writes the pages of this checkout; test_pages.py compares them",
}


@pytest.fixture(scope="module")
def small_checkout(copy, tmp_path_factory):
    """A checkout in which the paper is small, with its results, the sweeps of the pages and the files of studies."""
    folder = tmp_path_factory.mktemp("small") / "copy"
    shutil.copytree(copy, folder)
    (folder / "docs/data").mkdir()
    shutil.copy(folder / "config/paper.yaml", folder / "config/whole.yaml")
    small, paper = (
        yaml.safe_load((folder / f"config/{name}.yaml").read_text()) for name in ("smoke", "paper")
    )
    paper |= {key: small[key] for key in ("box_width", "cylinder", "record")}
    for shape in paper["shapes"].values():
        shape["granules"] = shape["granules"] * 60 // 400
    paper["sweep"] = {"case": ["c1", "d1", "e0", "e2", "c12"], "seed": [1, 2]}
    (folder / "config/paper.yaml").write_text(yaml.safe_dump(paper))
    for path in PAGES:
        for language, content in blocks(path.read_text(encoding="utf-8")):
            if name := re.match(r"# (\S+\.(?:py|yaml|csv))\n", content):
                if language == "yaml":
                    values = yaml.safe_load(content)
                    for axis in values["sweep"].values():
                        if isinstance(axis, list):
                            del axis[1:]
                    values["sweep"]["seed"] = 1
                    content = yaml.safe_dump(values)
                (folder / name[1]).write_text(content)
    with chdir(folder):
        for name in ("config/paper.yaml", "config/smoke.yaml", "friction.yaml"):
            of_file(Path(name))
        for file in findings.FILES:
            if not (target := Path("results") / file.source).exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file.path, target)
        Path("results/rft").mkdir(exist_ok=True)
        plated(plates(1e4)).to_netcdf("results/rft/scene.nc")
        Path("results/rough").mkdir()  # of no sweep
        shutil.copy("results/friction/drag.nc", "results/rough/drag.nc")
        shutil.copy("results/drag.nc", "docs/data/drag.nc")
        for name in ("snapshots", "precise"):
            shutil.copy(ROOT / f"docs/data/{name}.nc", "docs/data")
    return folder


def without(words, names, values=1):
    """Words of a command but for some options, each with its value."""
    left, skip = [], 0
    for word in words:
        skip = values + 1 if word in names else max(0, skip - 1)
        if not skip:
            left.append(word)
    return left


SHOWN = commands()
VERBS = [words for words in SHOWN if words[0] == "dem" or words[:3] == ("python", "-m", "studies")]


def application(words):
    """The application that words call and its words; the verb among them, and what stands behind it."""
    app, words = (dem_app, words[1:]) if words[0] == "dem" else (studies_app, words[3:])
    command, rest = get_command(app), [*words]
    while rest and rest[0] in getattr(command, "commands", ()):
        command = command.commands[rest.pop(0)]
    return app, words, command, rest


@pytest.mark.parametrize("words", VERBS, ids=shlex.join)
@posix
def test_a_verb_runs_as_it_is_shown(small_checkout, monkeypatch, words):
    """But for what needs a cluster or never ends; of a sweep the plan. A figure of one's own needs a file in the
    package."""
    monkeypatch.chdir(small_checkout)
    for name, reason in NOT_RUN.items():
        if shlex.join(words).startswith(name):
            pytest.skip(reason)
    if words[:3] == ("dem", "figure", "scatter"):
        workflows.run("-m", *words, cwd=small_checkout, path=[small_checkout])
        return
    app, rest, _, _ = application(words)
    rest = without(without(rest, ENDLESS, values=0), ELSEWHERE)
    if rest[0] == "sweep" and "--dry-run" not in rest:
        rest = [*rest, "--dry-run"]
    run = CliRunner().invoke(app, rest)
    assert run.exit_code == 0, run.output + "".join(traceback.format_exception(run.exception))


def verbs():
    """All verbs of both applications, as the words that call them."""
    for program, app in (("dem",), dem_app), (("python", "-m", "studies"), studies_app):
        for name, group in get_command(app).commands.items():
            for verb in getattr(group, "commands", {"": group}):
                yield tuple(filter(None, (*program, name, verb)))


BY_RULES = [
    verb  # of a shell command
    for path in RULES
    for verb in re.findall(r"(?:\bdem|-m studies [{}\w.]+) ([{}\w.]+)", path.read_text("utf-8"))
]


@pytest.mark.parametrize("verb", [*verbs()], ids=shlex.join)
def test_every_verb_has_help_and_is_shown_or_called_by_a_rule(verb):
    """--help says what it does, and what each option is for. What runs above, and the targets below, enter all
    verbs; one that is neither has no use."""
    *_, command, _ = application(verb)
    assert command.help and all(option.help for option in command.params)
    assert verb[-1] in BY_RULES or any(words[: len(verb)] == verb for words in SHOWN)


def test_verbs_and_options_within_sentences_exist():
    for path in PAGES:
        text = path.read_text(encoding="utf-8")
        for shown in re.findall(r"`((?:dem|python -m studies) [a-z][^`]*)`", text):
            _, _, command, rest = application(shlex.split(shown))
            names = {"--help", *(name for parameter in command.params for name in parameter.opts)}
            options = {re.sub(r"^(-\w).+", r"\1", word) for word in rest if word.startswith("-")}
            assert options <= names and not hasattr(command, "commands"), f"{path}: {shown}"


@posix
def test_every_target_can_be_planned(copy):
    """All that Snakemake lists, at once; those that pages and rules show are among them."""
    process = workflows.snakemake(copy, "--list-target-rules", configfile=None)
    targets = set(process.stdout.split())
    options = "--configfile", "--profile", "--workflow-profile", "--report"
    shown = [without(words[1:], options) for words in SHOWN if words[0] == "snakemake"]
    shown = {word for words in shown for word in words if not word.startswith("-")}
    assert len(targets) > 8 and shown <= targets
    workflows.completed(copy, *sorted(targets), "-n", configfile=None)


CONFIGURED = [words for words in SHOWN if words[0] == "snakemake" and "--configfile" in words]


@posix
@pytest.mark.parametrize("words", CONFIGURED, ids=shlex.join)
def test_a_sweep_that_is_shown_can_be_planned(copy, small_checkout, monkeypatch, words):
    """By what plans the runs for Snakemake."""
    file = Path(words[words.index("--configfile") + 1])
    monkeypatch.chdir(copy if file.parts[0] == "studies" else small_checkout)
    work = SweepState.of(file)
    work.check()
    assert all(work.batches(name) for name in work.sweep.blocks if work.is_known(name))


HOWTO = sorted(ROOT.glob("docs/howto/*.md"))


@pytest.mark.parametrize("path", HOWTO, ids=lambda path: path.stem)
def test_the_sweeps_of_a_page_can_be_planned(small_checkout, monkeypatch, path):
    """Whole files, named in their first line, and fragments, with where they belong."""
    monkeypatch.chdir(small_checkout)
    for content in pieces(path, "yaml"):
        role = re.match(r"# (\w+\.yaml|below sweep|in place of sweep)\n", content)[1]
        if role == "below sweep":
            content = "sweep:\n" + textwrap.indent(content, "  ")
        if "sweep" in role:
            shape = "" if "shape:" in content else "  shape: [c1]\n"
            content = f"extends: config/paper.yaml\nresults: results/shown\n{content}{shape}"
        Path("shown.yaml").write_text(content.replace("config/paper.", "config/whole."))
        run = called("sweep shown.yaml --dry-run")
        assert run.exit_code == 0, run.output


WITH_PYTHON = [path for path in PAGES if pieces(path, "python")]


@pytest.mark.parametrize("path", WITH_PYTHON, ids=lambda path: f"{path.relative_to(ROOT)}")
def test_python_of_a_page_runs_as_it_is_shown(small_checkout, monkeypatch, path):
    """One piece after another; a file that it names first is written."""
    folder = small_checkout
    if path.name == "results.md":  # which says that it runs where it is
        folder = small_checkout / path.relative_to(ROOT).parent
        folder.mkdir(exist_ok=True)
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(small_checkout)
    names = {"__name__": "page", "dem": dem}  # which the cells of a notebook import
    with matplotlib.rc_context({"backend": "agg"}):
        for piece in pieces(path, "python"):
            if not re.match(r"# [\w/]+\.py\n", piece):
                exec(compile(piece, path, "exec"), names)


def test_what_is_a_notebook_runs_in_the_build_of_the_pages():
    """All cells, and an error or a warning ends the build, which guards the main branch."""
    conf = runpy.run_path(str(ROOT / "docs/conf.py"))
    assert conf["nb_execution_mode"] == "force" and conf["nb_execution_raise_on_error"]
    assert conf["nb_execution_excludepatterns"] == []
    assert "make docs" in (ROOT / ".ci/run").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "words",
    [words for words in SHOWN if words[0] in ("pip", "make", "bash", "python")],
    ids=shlex.join,
)
def test_what_other_programs_are_asked_for_is_there(words):
    """Extras of the package, goals of the Makefile, scripts."""
    match words:
        case ["pip", "install", wanted] if wanted.startswith(".["):
            project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))[
                "project"
            ]
            assert wanted[2:-1] in project["optional-dependencies"]
        case ["make", *_]:
            subprocess.run([*words, "-n"], cwd=ROOT, check=True)
        case [_, script, *_] if script.endswith((".py", ".sh")):
            assert (ROOT / script).is_file()
