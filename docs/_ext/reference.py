"""What the pages of the reference list, from the code: keys, variables, verbs, names.

docs/reference/X.md.in has the words around these tables, and docs/write_pages.py fills them in.
"""

import inspect
import re
from importlib import import_module
from operator import attrgetter
from os.path import relpath
from typing import get_origin

from typer.main import get_command

import dem
from dem.base.refusals import section_of, unit_of
from dem.base.source_hash import ROOT
from dem.base.types import LEAST
from dem.cli.app import app
from dem.experiment.kinds import EXPERIMENTS
from dem.experiment.observables import OBSERVABLES
from dem.io.dataset import LABELS, OF_RUN, OF_STORE, OF_SWEEP
from dem.sweep.config import Sweep
from dem.sweep.design import Design
from dem.sweep.json_schema import of_model, schema
from dem.sweep.precision import Until
from studies import package_of
from studies.catalogue import reported

FOLDER = ROOT / "docs/reference"
# by key of a JSON schema: what is said of a value
LIMITS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
TYPES = {
    "integer": "whole",
    "number": "number",
    "boolean": "true, false",
    "string": "text",
    "array": "list",
    "object": "group",
}


def keys() -> str:
    """All keys of a sweep file, a table for each section; sections with the same keys share one."""
    places = {Sweep: [""]} | _places(Sweep, "")
    places |= {Until: ["sweep.seed"], Design: ["sweep.NAME"]} | _places(Design, "sweep.NAME.")
    tree, text = schema(), ""
    for section, (path, *others) in places.items():
        needs = {k: v["SECTIONS"].get(path.removesuffix(".LABEL")) for k, v in EXPERIMENTS.items()}
        kinds = [f"{k} (required)" if need else k for k, need in needs.items() if need is not None]
        text += f"\n## `{path}`\n\n" if path else ""
        text += f"The same keys: {_code(others)}.\n\n" if others else ""
        text += f"Experiments: {', '.join(kinds)}.\n\n" if kinds else ""
        forms = tree if section is Sweep else of_model(section)
        rows = [_key(name, form, section, places) for name, form in forms["properties"].items()]
        text += _table(("key", "meaning", "unit", "range", "default"), rows)
    return text


def _places(model, head: str) -> dict[type, list[str]]:
    """The paths of each section below a model."""
    places = {}
    for name, field in model.model_fields.items():
        if section := section_of(field.annotation):
            path = head + name + ".LABEL" * (get_origin(field.annotation) is dict)
            for inner, paths in ({section: [path]} | _places(section, f"{path}.")).items():
                places[inner] = places.get(inner, []) + paths
    return places


def _key(name: str, form: dict, model, places: dict) -> tuple:
    """A row: key, meaning, unit, range and default of a value."""
    about, _, absent = form.get("description", "").partition("; none: ")
    field, default = model.model_fields.get(name), form.get("default", "required")
    section = section_of(field and field.annotation)
    if section:
        unit, allowed = "", f"[keys](#{places[section][0].replace('.', '').lower()})"
    else:
        unit, allowed = field and unit_of(field.rebuild_annotation()), _allowed(form)
    usual = "none" if default is None or isinstance(default, dict) else str(default)
    return _code([name]), about, unit, allowed, absent or usual.replace("False", "false")


def _allowed(form: dict) -> str:
    """Values that a schema allows."""
    if "anyOf" in form:
        return ", or ".join(filter(None, map(_allowed, form["anyOf"])))
    if words := form.get("enum") or form.get("examples") or form.get("const"):
        return _code([words] if isinstance(words, str) else words)
    limits = [f"{sign} {form[key]:.10g}" for key, sign in LIMITS.items() if key in form]
    words = [TYPES[form["type"]]] if form["type"] in TYPES else []
    text = ", ".join(words + limits).replace(f"≥ {LEAST:g}", "> 0")
    return text.removeprefix("number, ")


def variables() -> str:
    """All variables of files, a table for each kind of experiment, observable and study."""
    modules = {f"Experiment `{name}`": f"dem.experiment.kinds.{name}" for name in EXPERIMENTS}
    modules |= {
        f"Observable `{name}`": f"dem.experiment.observables.{name}" for name in OBSERVABLES
    }
    modules |= {f"Study `{name}`": f"{package_of(name)}.results" for name in reported()}
    text = _layout(OF_STORE | LABELS | OF_SWEEP)
    text += f"\n## Of each run that records observables\n\n{_layout(OF_RUN)}"
    for head, name in modules.items():
        module = import_module(name)
        about, _, _ = module.__doc__.partition("\n\n")
        text += f"\n## {head}\n\n{about}\n\n"
        text += _layout(getattr(module, "AXIS", {}) | getattr(module, "VARIABLES", {}))
    return text


def _layout(table: dict) -> str:
    rows = [(_code([n]), what, ", ".join(dims), unit) for n, (dims, unit, what) in table.items()]
    return _table(("variable", "meaning", "dimensions", "unit"), rows)


def verbs() -> str:
    """All verbs of `dem` with their arguments and options."""
    text, heads = "", ("argument or option", "meaning", "default")
    for name, verb in get_command(app).commands.items():
        rows = [
            (_code(each.opts), each.help, "required" if each.required else each.default)
            for each in verb.params
        ]
        about = re.sub("(?<=Example: )(.*)", r"`\1`", verb.help)
        text += f"\n## `dem {name}`\n\n{about}\n\n{_table(heads, rows)}"
    return text


def names() -> str:
    """All public names with the first sentence about each, in the order of the page for autodoc."""

    def listed(found) -> str:
        rows = []
        for name in re.findall(r"^   ~?([\w.]+)$", found[1], re.M):
            thing = attrgetter(name)(dem)
            source = relpath(inspect.getsourcefile(inspect.unwrap(thing)), FOLDER)
            rows.append((f"[`{name}`]({source})", inspect.getdoc(thing).partition("\n\n")[0]))
        return _table(("name", "meaning"), rows)

    text = (FOLDER / "api.md").read_text(encoding="utf-8")
    return re.sub(r"```\{eval-rst\}\n(.*?)```\n", listed, text[text.index("## ") :], flags=re.S)


def _code(words) -> str:
    return ", ".join(f"`{word}`" for word in words)


def _table(heads, rows) -> str:
    """A table of Markdown; a short cell, such as a unit, is one word."""
    text = f"| {' | '.join(heads)} |\n{'|:--' * len(heads)}|\n"
    for row in rows:
        cells = [str(cell or "").replace("\n", " ") for cell in row]
        cells = [cell.replace(" ", "\N{NO-BREAK SPACE}"[len(cell) > 8 :] or " ") for cell in cells]
        text += f"| {' | '.join(cells)} |\n"
    return text
