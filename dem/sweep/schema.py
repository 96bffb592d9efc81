"""The schema of sweep files, by which editors complete and check them: python -m dem.sweep.schema

It writes config/schema.json from the models. No key is required there, because a file may extend
another; what is missing, and what does not fit together, is said when the file is read.
"""

import json
from typing import Annotated

from pydantic import TypeAdapter

from dem.base.files import atomic
from dem.base.schema import LIMITS
from dem.base.sources import ROOT
from dem.experiment.config import entries
from dem.sweep.axis import RUNS, Derive
from dem.sweep.config import Sweep
from dem.sweep.design import Design
from dem.sweep.precision import Until

FILE = ROOT / "config/schema.json"
LEFT_OUT = {"required": list, "title": str, "before": object}  # by the type that the word has then


def schema() -> dict:
    """The schema as plain groups."""
    found = _plain(Sweep.model_json_schema())
    for model in (Design, Derive, Until):
        own = _plain(model.model_json_schema())
        found["$defs"] |= own.pop("$defs", {}) | {model.__name__: own}
    values = {name: _one(entry) for name, entry in (entries(()) | RUNS).items()}
    block = {name: _many(one) for name, one in values.items()}
    names = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
    shared = {
        name: {"anyOf": [one, {"type": "object"}]} for name, one in values.items()
    }  # factors, or derived
    block |= {"needs": names, "values": {"type": "object", "properties": shared}}
    block["blocks"] = {"type": "object", "additionalProperties": {"$ref": "#/$defs/Block"}}
    found["$defs"]["Block"] = {"type": "object", "properties": block}
    found["additionalProperties"] = {
        "type": "object",
        "description": "values of an experiment of your own",
    }
    found["properties"]["sweep"] = {"$ref": "#/$defs/Block"}
    found["patternProperties"] = {"^x-": {}}  # for anchors
    found["properties"]["extends"] = {"type": "string", "description": "file that this one changes"}
    return found


def _one(entry) -> dict:
    field = entry.field
    return _plain(TypeAdapter(Annotated[(field.annotation, field)]).json_schema())


def _many(one: dict) -> dict:
    """Some values, or one, or seeds as words, or factors."""
    several = {"type": "array", "items": one}
    return {"anyOf": [one, several, {"type": ["string", "object"]}]}


def _plain(tree):
    """A schema without what an editor does not need, and with its words for limits."""
    if isinstance(tree, list):
        return [_plain(each) for each in tree]
    if not isinstance(tree, dict):
        return tree
    kept = {k: v for k, v in tree.items() if not isinstance(v, LEFT_OUT.get(k, ()))}
    return {LIMITS.get(key, key): _plain(each) for key, each in kept.items()}


if __name__ == "__main__":
    with atomic(FILE) as part:
        part.write_text(json.dumps(schema(), indent=1) + "\n", encoding="utf-8")
