"""YAML files: UTF-8 text in, plain values out, one sentence with its line for anything else.

Values are judged by their types (dem.base.types). Only what YAML reads as another value than it
looks is refused here.
"""

import re
from pathlib import Path

import yaml

from dem.base.errors import InputError
from dem.base.files import reason
from dem.base.messages import did_you_mean

OTHER_BASE = re.compile(r"[-+]?0\w+|.*:.*")  # of a number in YAML 1.1: 8, 16, 2 or 60


def read(path: Path) -> dict:
    """Keys and values of a YAML file; raises InputError with the line of what is wrong."""
    try:
        data = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except RecursionError:
        raise InputError(f"{path}: values are nested too deep.") from None
    except yaml.reader.ReaderError as error:
        raise InputError(f"{path}: it holds the character {chr(error.character)!r}.") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        words = ", ".join(filter(None, (error.context, error.problem)))
        raise InputError(f"{path}, line {mark.line + 1}: {words}.") from None
    except (OSError, LookupError, ValueError) as error:
        names = [file.name for file in Path(path).parent.glob("*")]
        hint = isinstance(error, FileNotFoundError) and did_you_mean(Path(path).name, names, "")
        raise InputError(f"{path}: cannot read it ({reason(error)}){hint or ''}.") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: it must hold keys with values, see config/paper.yaml.")
    return data


class _Loader(yaml.SafeLoader):
    """PyYAML's, without dates, numbers to other bases than 10, truth values as keys, keys that are there
    twice, and lists in themselves."""

    def compose_node(self, parent, index):
        node = super().compose_node(parent, index)
        if node.end_mark is None:  # of a list or a group that has not ended
            _refuse(node, "an alias contains itself")
        return node

    def compose_scalar_node(self, anchor):
        node = super().compose_scalar_node(anchor)
        kind, text = node.tag.rpartition(":")[2], node.value[:40]
        if kind == "timestamp":
            _refuse(node, f"YAML reads {text!r} as a date; put it in quotes")
        if kind in ("int", "float") and OTHER_BASE.fullmatch(text):
            value = self.construct_object(node)
            _refuse(node, f"YAML reads {text} as {value}; write a decimal number, or quotes")
        return node

    def compose_mapping_node(self, anchor):
        node, lines = super().compose_mapping_node(anchor), {}
        for key, _ in node.value:
            if key.tag.endswith(":bool"):
                words = f"YAML reads the key {key.value} as a truth value"
                _refuse(key, f"{words}; use another name, or quotes")
            if (name := str(key.value)) in lines:
                _refuse(key, f"{name!r} is a key here and in line {lines[name]}; remove one")
            lines[name] = key.start_mark.line + 1
        return node


def _refuse(node: yaml.Node, words: str):
    raise yaml.MarkedYAMLError(problem=words, problem_mark=node.start_mark)
