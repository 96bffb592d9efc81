"""Write the reference pages that follow from the code: command line, configuration, files."""

import json
from importlib import import_module
from pathlib import Path

import typer
from typer.cli import get_docs_for_click

from dem.base.refusals import section_of, unit_of
from dem.base.source_hash import ROOT
from dem.base.types import LEAST
from dem.cli.app import app
from dem.experiment.config import SECTIONS, Configuration
from dem.experiment.kinds import EXPERIMENTS, jamming, onset, shear
from dem.experiment.observables import OBSERVABLES
from dem.io import dataset
from studies import package_of
from studies.catalogue import reported

FOLDER = Path("_generated")  # in docs


def write(docs: Path) -> None:
    """Write docs/_generated/{command_line,configuration,files}.md."""
    (docs / FOLDER).mkdir(exist_ok=True)
    for name, page in PAGES.items():
        (docs / FOLDER / f"{name}.md").write_text(page(), encoding="utf-8")


def command_line() -> str:
    """Every verb of `dem` with its options, from the code."""
    command = typer.main.get_command(app)
    context = typer.Context(command, info_name="dem")
    return get_docs_for_click(obj=command, ctx=context, name="dem", title="The command line")


def configuration() -> str:
    """Every value of a configuration, from its fields and the schema."""
    schema = json.loads((ROOT / "config/schema.json").read_text(encoding="utf-8"))
    parts = ["# The configuration\n", CONFIGURATION]
    parts += [
        "## The whole run\n",
        _table(HEADS, _values(Configuration, "", schema)),
    ]
    for name, field in Configuration.model_fields.items():
        if section := section_of(field.annotation):
            parts.append(f"## {name}\n")
            if name in SECTIONS:
                kinds = (kind for kind, header in EXPERIMENTS.items() if name in header["SECTIONS"])
                parts.append(f"Only for the experiment {' and '.join(kinds)}.\n")
            label = "LABEL." if name == "shapes" else ""
            parts.append(
                _table(
                    HEADS, _values(section, f"{name}.{label}", schema["$defs"][section.__name__])
                )
            )
    return "\n".join(parts)


HEADS = ("key", "what it is", "unit", "allowed", "default")
CONFIGURATION = """\
A configuration is a YAML file in SI units. These are the values that one run reads. Each of them but
`record.window` and `record.observables` can vary in a sweep, by its key. [How do I sweep my own values?](../howto/sweep.md) explains the rest of
the file: `title`, `results`, `extends`, `cases`, `sweep`, `batch`, `failures`, `studies`.
"""


# by key of a JSON schema: what is said of a value
LIMITS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
TYPES = {
    "integer": "whole",
    "boolean": "true, false",
    "string": "text",
    "array": "list",
    "null": "none",
}


def _allowed(form: dict) -> str:
    """Values that a schema allows."""
    if "anyOf" in form:
        return "; ".join(map(_allowed, form["anyOf"]))
    if "enum" in form:
        return ", ".join(f"`{each}`" for each in form["enum"])
    limits = [f"{sign} {form[key]:g}" for key, sign in LIMITS.items() if key in form]
    words = [TYPES[form["type"]]] if form["type"] in TYPES else []
    return ", ".join(words + limits).replace(f"≥ {LEAST:g}", "> 0")


def _values(section, head: str, schema: dict) -> list[tuple[str, ...]]:
    """Rows of a table: key, meaning, unit, allowed values and default of a section's values."""
    rows = []
    for name, field in section.model_fields.items():
        if section_of(field.annotation):
            continue
        units = unit_of(field.rebuild_annotation()) or ""
        default = "required" if field.is_required() else _word(field.default)
        allowed = _allowed(schema["properties"][name])
        rows.append((f"`{head}{name}`", field.description, units, allowed, default))
    return rows


def _word(default) -> str:
    if isinstance(default, tuple):
        return ", ".join(default)
    return "none" if default is None else str(default).lower()


def files() -> str:
    """Every variable of every file of results, from the layouts."""
    parts = ["# The files of results\n", FILES]
    runs = dataset.OF_STORE | dataset.LABELS | EXPERIMENTS["drag"]["AXIS"] | dataset.OF_RUN
    parts += ["## In every file of runs\n", _variables(runs)]
    for name in OBSERVABLES:
        module = import_module(f"dem.experiment.observables.{name}")
        parts += [f"## Observable `{name}`\n", _first_line(module), _variables(module.VARIABLES)]
    for module in (jamming, onset, shear):
        name = module.__name__.rpartition(".")[2]
        parts += [f"## Experiment `{name}`\n", _first_line(module), _variables(module.VARIABLES)]
    for name in reported():
        results = import_module(f"{package_of(name)}.results")
        parts += [f"## `{name}.nc`\n", _variables(results.VARIABLES)]
    return "\n".join(parts)


FILES = """\
All files are netCDF-4 and follow the CF conventions, version 1.11. Units are SI. Any netCDF program
reads them; `dem info FILE` prints a summary. A combined file such as `drag.nc` adds the dimensions of
its sweep, for example `case` and `seed`, in front of the dimensions given here. It leaves out `bed_family`,
`spent` and `failure_reason`, and holds `failure` only if runs were allowed to fail.
"""


def _first_line(module) -> str:
    return module.__doc__.partition("\n")[0] + "\n"


def _variables(layout: dict) -> str:
    rows = [
        (
            f"`{name}`",
            about or ("edges of the bins" if name.endswith("bounds") else ""),
            ", ".join(dimensions) or "-",
            units or "",
        )
        for name, (dimensions, units, about) in layout.items()
    ]
    return _table(("variable", "what it is", "dimensions", "unit"), rows)


def _table(heads, rows) -> str:
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(str(cell) for cell in line)} |" for line in lines) + "\n"


PAGES = {"command_line": command_line, "configuration": configuration, "files": files}
