"""The schema of sweep files, by which editors complete and check them: python -m dem.sweep.json_schema

It writes config/schema.json from the models. No key is required there, because a file may extend
another; what is missing, and what does not fit together, is said when the file is read.
"""

import json

from dem.base.files import write_bytes
from dem.base.source_hash import ROOT
from dem.experiment.config import entries
from dem.sweep.axis import RUNS
from dem.sweep.config import TABLES, Sweep

FILE = ROOT / "config/schema.json"
# words of pydantic for limits of numbers that it parses, and of JSON Schema
LIMITS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}


def schema() -> dict:
    """The schema as plain groups."""
    text = json.dumps(Sweep.model_json_schema())
    for word, limit in LIMITS.items():
        text = text.replace(f'"{word}": ', f'"{limit}": ')
    tree = json.loads(text)
    values = {
        name: {"description": f"{entry.field.description} ({entry.units or 'text'})"}
        for name, entry in (entries() | RUNS).items()
    }
    blocks = {"type": "object", "additionalProperties": {"$ref": "#/$defs/Block"}}
    shared = {"type": "object", "properties": values}
    properties = values | {"needs": {}, "values": shared, "blocks": blocks}
    tree["$defs"]["Block"] = {"type": "object", "properties": properties}
    tree["additionalProperties"] = {"type": "object"}  # values of an experiment of the user's own
    tree["properties"] |= {"sweep": {"$ref": "#/$defs/Block"}, "extends": {"type": "string"}}
    for name in TABLES:  # null takes a label out of the file that another extends
        rows = tree["properties"][name].setdefault("patternProperties", {})
        for label, row in rows.items():
            rows[label] = {"anyOf": [row, {"type": "null"}]}
    tree["patternProperties"] = {"^x-": {}}  # for anchors
    return tree


if __name__ == "__main__":
    write_bytes(FILE, f"{json.dumps(schema(), indent=1)}\n".encode())
