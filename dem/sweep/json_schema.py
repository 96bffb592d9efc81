"""The schema of sweep files, by which editors complete and check them: python -m dem.sweep.json_schema

It writes config/schema.json from the models. No key is required there, because a file may extend
another; what is missing, and what does not fit together, is said when the file is read.
"""

import json

from dem.base.files import write_bytes
from dem.base.source_hash import ROOT
from dem.base.types import Section
from dem.experiment.entries import entries
from dem.sweep.axis import RUNS
from dem.sweep.config import TABLES, Sweep

FILE = ROOT / "config/schema.json"
# words of pydantic for limits of numbers that it parses, and of JSON Schema
LIMITS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}

EXTENDS = {
    "type": "string",
    "default": None,
    "description": "file whose values hold where this file gives none; none: no other file",
}


def of_model(model: type[Section]) -> dict:
    """The schema of a model alone, as plain groups."""
    text = json.dumps(model.model_json_schema())
    for word, limit in LIMITS.items():
        text = text.replace(f'"{word}": ', f'"{limit}": ')
    return json.loads(text)


def schema() -> dict:
    """The schema as plain groups."""
    tree = of_model(Sweep)
    values = {
        name: {"description": f"{entry.field.description} ({entry.units or 'text'})"}
        for name, entry in (entries(Sweep.read) | RUNS).items()
    }
    blocks = {"type": "object", "additionalProperties": {"$ref": "#/$defs/Block"}}
    shared = {"type": "object", "properties": values}
    properties = values | {"needs": {}, "values": shared, "blocks": blocks}
    tree["$defs"]["Block"] = {"type": "object", "properties": properties}
    tree["additionalProperties"] = {"type": "object"}  # values of an experiment of the user's own
    tree["properties"]["sweep"]["$ref"] = "#/$defs/Block"
    tree["properties"]["extends"] = EXTENDS
    for name in TABLES:  # null takes a label out of the file that another extends
        rows = tree["properties"][name].setdefault("patternProperties", {})
        for label, row in rows.items():
            rows[label] = {"anyOf": [row, {"type": "null"}]}
    tree["patternProperties"] = {"^x-": {}}  # for anchors
    return tree


if __name__ == "__main__":
    write_bytes(FILE, f"{json.dumps(schema(), indent=1)}\n".encode())
