"""What code, pages and rules name is there and runs, found from them: no list to keep."""

import ast
import re
import runpy
import shlex
import shutil
import sys
import tomllib
import traceback
from contextlib import chdir, suppress
from itertools import chain
from pathlib import Path

import matplotlib
import pytest
import yaml
from markdown_it import MarkdownIt
from project import CONFIG, posix
from sweeps import of_file
from typer.main import get_command
from typer.testing import CliRunner
from workflows import snakemake

import dem
from dem.cli.app import app as dem_app
from dem.sweep.state import SweepState
from studies.__main__ import app as studies_app

sys.path.append(str(CONFIG.parent / "docs/_ext"))
import findings

ROOT = CONFIG.parent
OURS = "dem", "studies"


# Who shows a command: pages, and the docstrings of rules, modules and verbs.
PAGES = [
    *sorted(ROOT.glob("*.md")),
    *sorted(ROOT.glob("docs/**/*.md")),
    *sorted(ROOT.glob("studies/*/README.md")),
    *sorted(ROOT.glob("dem/**/*.md")),
]
# what the build writes
LEFT_OUT = {"_build", "_generated", "jupyter_execute"}
PAGES = [path for path in PAGES if not LEFT_OUT & set(path.parts)]
SOURCES = [path for room in OURS for path in sorted((ROOT / room).rglob("*.py"))]
RULES = [ROOT / "Snakefile", *sorted(ROOT.glob("rules/*.smk"))]


def blocks(text):
    """Pieces of code in Markdown: language, empty where it is indented, and content."""
    for token in MarkdownIt().parse(text):
        if token.type in ("fence", "code_block"):
            yield token.info.strip(), token.content


def docstrings(path):
    """Those of a file of rules, or of a module and all in it."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        yield re.match(r'"""(.*?)"""', text, re.S)[1]
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef):
            yield ast.get_docstring(node) or ""


def lines():
    """Where a command is shown, and its line."""
    for path in PAGES:
        for language, content in blocks(path.read_text(encoding="utf-8")):
            if language in ("", "bash", "sh", "console"):
                sign = r"\$ " if language == "console" else ""
                yield from ((path, line) for line in re.findall(f"^{sign}(.*)", content, re.M))
    for path in (*RULES, *SOURCES):
        for text in docstrings(path):
            for _, content in blocks(text):
                shown = re.sub(r"  +[a-z].*", "", content)  # without words beside a command
                yield from ((path, line) for line in shown.splitlines())
            yield from ((path, line) for line in re.findall(r"Example: (.*)", text))


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


# Whose commands are not ours: their words are checked as far as they name something of ours.
THEIRS = shlex.split("git cd pre-commit source . dask apt paraview python3 coverage sbatch")
PROGRAMS = "dem", "snakemake", "python", "make", "pip", "bash", "pytest", *THEIRS
# What a command takes that a test cannot give, and what is left out then.
ENDLESS, ELSEWHERE = ("--watch",), ("--scheduler", "--wait")
NOT_RUN = {
    "dem figure scatter": "a figure of one's own, which test_pages.py puts into a copy of the package",
    "python -m studies calibration fit": "its interval takes hundreds of runs; test_calibration.py has them",
    "python docs/data/release.py": "it writes the files of this checkout; test_pages.py reads it",
    "python docs/write_pages.py": "it writes the pages of this checkout; test_pages.py compares them",
}


def smallest(sweep):
    """A sweep with the first value of each axis."""
    first = {name: axis[:1] for name, axis in sweep.items() if isinstance(axis, list)}
    return sweep | first | {"seed": 1}


@pytest.fixture(scope="module")
def small_checkout(copy, tmp_path_factory):
    """A checkout in which the paper is small, with its results, the sweeps of the pages and the files of studies."""
    folder = tmp_path_factory.mktemp("small") / "copy"
    shutil.copytree(copy, folder)
    (folder / "docs/data").mkdir()
    small, paper = (
        yaml.safe_load((folder / f"config/{name}.yaml").read_text()) for name in ("smoke", "paper")
    )
    shapes = {
        name: shape | {"granules": shape["granules"] * 60 // 400}
        for name, shape in paper["shapes"].items()
    }
    paper |= {key: small[key] for key in ("box_width", "cylinder", "record")} | {"shapes": shapes}
    paper["sweep"] = {"case": ["c1", "d1", "e0", "e2", "c12"], "seed": [1, 2]}
    (folder / "config/paper.yaml").write_text(yaml.safe_dump(paper))
    for path in PAGES:
        for language, content in blocks(path.read_text(encoding="utf-8")):
            if language == "yaml" and (name := re.match(r"# (\w+\.yaml)\n", content)):
                values = yaml.safe_load(content)
                (folder / name[1]).write_text(
                    yaml.safe_dump(values | {"sweep": smallest(values["sweep"])})
                )
            if language == "python" and (name := re.match(r"# (\w+\.py)\n", content)):
                (folder / name[1]).write_text(content)
    with chdir(folder):
        for name in ("config/paper.yaml", "config/smoke.yaml", "friction.yaml"):
            of_file(Path(name))
        for file in findings.FILES:
            if not (target := Path("results") / file.source).exists():
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy(file.path, target)
        Path("results/rough").mkdir()  # of no sweep
        shutil.copy("results/friction/drag.nc", "results/rough/drag.nc")
        shutil.copy("results/drag.nc", "docs/data/drag.nc")
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


@pytest.mark.parametrize("words", VERBS, ids=shlex.join)
@posix
def test_a_verb_runs_as_it_is_shown(small_checkout, monkeypatch, words):
    """But for what needs a cluster or never ends; of a sweep the plan."""
    monkeypatch.chdir(small_checkout)
    for name, reason in NOT_RUN.items():
        if shlex.join(words).startswith(name):
            pytest.skip(reason)
    app, rest = (dem_app, words[1:]) if words[0] == "dem" else (studies_app, words[3:])
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


@pytest.mark.parametrize("verb", [*verbs()], ids=shlex.join)
def test_every_verb_has_help(verb):
    """--help says what each verb does, and what each of its options is for."""
    app, words = (dem_app, verb[1:]) if verb[0] == "dem" else (studies_app, verb[3:])
    result = CliRunner().invoke(app, [*words, "--help"], env={"COLUMNS": "200", "TERM": "dumb"})
    assert result.exit_code == 0, result.output
    command = get_command(app)
    for word in words:
        command = command.commands[word]
    assert command.help.split()[0] in result.output
    assert all(option.help for option in command.params)


def called_by_rules():
    """The verbs in the rules' shell commands, their names filled in."""
    for path in RULES:
        text = path.read_text(encoding="utf-8")
        yield from re.findall(r"(?:\bdem|-m studies [{}\w.]+) ([{}\w.]+)", text)


def test_every_verb_is_shown_or_called_by_a_rule():
    """So that what runs above, and the targets below, enter all of them; what is neither has no use."""
    called = set(called_by_rules())
    unused = [
        shlex.join(verb)
        for verb in verbs()
        if not any(words[: len(verb)] == verb for words in SHOWN) and verb[-1] not in called
    ]
    assert unused == []


def mentioned():
    """Commands of ours within the sentences of pages: page and words."""
    for path in PAGES:
        for block in MarkdownIt().parse(path.read_text(encoding="utf-8")):
            for token in block.children or ():
                if token.type == "code_inline" and re.match(
                    r"dem [a-z]|python -m studies [a-z]", token.content
                ):
                    yield path, shlex.split(token.content)


def test_verbs_and_options_within_sentences_exist():
    wrong = []
    for path, words in mentioned():
        app, rest = (dem_app, words[1:]) if words[0] == "dem" else (studies_app, words[3:])
        command = get_command(app)
        while rest and hasattr(command, "commands") and rest[0] in command.commands:
            command = command.commands[rest.pop(0)]
        names = {"--help", *(name for parameter in command.params for name in parameter.opts)}
        options = {re.sub(r"^(-\w).+", r"\1", word) for word in rest if word.startswith("-")}
        if not options <= names or hasattr(command, "commands"):
            wrong.append(f"{path}: {shlex.join(words)}")
    assert wrong == []


def options_of(words):
    """Words of Snakemake as configuration file, profile and what is left, targets first."""
    rest = without(words[1:], ("--configfile", "--profile", "--workflow-profile", "--report"))
    return [word for word in rest if not word.startswith("-")]


@posix
def test_every_target_can_be_planned(copy):
    """All that Snakemake lists, at once; those that pages and rules show are among them."""
    process = snakemake(copy, "--list-target-rules", configfile=None)
    targets = set(process.stdout.split())
    shown = [options_of(words) for words in SHOWN if words[0] == "snakemake"]
    assert len(targets) > 8 and set(chain(*shown)) <= targets
    run = snakemake(copy, *sorted(targets), "-n", configfile=None)
    assert run.returncode == 0, run.stdout + run.stderr


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


def pieces(path):
    """The Python that a page shows."""
    text = path.read_text(encoding="utf-8")
    return [content for language, content in blocks(text) if language == "python"]


@pytest.mark.parametrize(
    "path", [*filter(pieces, PAGES)], ids=lambda path: f"{path.relative_to(ROOT)}"
)
def test_python_of_a_page_runs_as_it_is_shown(small_checkout, monkeypatch, path):
    """One piece after another; a file that it names first is written."""
    monkeypatch.chdir(small_checkout)
    monkeypatch.syspath_prepend(small_checkout)
    names = {"__name__": "page", "dem": dem}  # which the cells of a notebook import
    with matplotlib.rc_context({"backend": "agg"}):
        for piece in pieces(path):
            if not re.match(r"# [\w/]+\.py\n", piece):
                exec(compile(piece, path, "exec"), names)


def test_what_is_a_notebook_runs_in_the_build_of_the_pages():
    """All cells, and an error ends the build, which guards the main branch."""
    conf = runpy.run_path(str(ROOT / "docs/conf.py"))
    assert conf["nb_execution_mode"] == "force" and conf["nb_execution_raise_on_error"]
    assert conf["nb_execution_excludepatterns"] == []
    assert "make docs" in (ROOT / ".ci/run").read_text(encoding="utf-8")
    cells = [
        path
        for path in PAGES
        if any("{code-cell}" in kind for kind, _ in blocks(path.read_text(encoding="utf-8")))
    ]
    assert cells and all(
        "file_format: mystnb" in path.read_text(encoding="utf-8")[:200] for path in cells
    )


EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
    "optional-dependencies"
]


@pytest.mark.parametrize(
    "words",
    [words for words in SHOWN if words[0] in ("pip", "make", "bash", "python")],
    ids=shlex.join,
)
def test_what_other_programs_are_asked_for_is_there(words):
    """Extras of the package, goals of the Makefile, scripts."""
    match words:
        case ["pip", "install", wanted] if wanted.startswith(".["):
            assert wanted[2:-1] in EXTRAS
        case ["make", *goals]:
            targets = re.findall(r"^([\w./]+):", (ROOT / "Makefile").read_text(), re.M)
            assert set(without(goals, (), 0)) - {g for g in goals if "=" in g} <= set(targets)
        case [_, script, *_] if script.endswith((".py", ".sh")):
            assert (ROOT / script).is_file()
