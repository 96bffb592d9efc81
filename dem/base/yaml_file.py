"""YAML files: UTF-8 text in, plain values out, one sentence with its line for anything else."""

import re
from contextlib import suppress
from pathlib import Path

import yaml

from dem.base.errors import InputError
from dem.base.files import reason
from dem.base.messages import did_you_mean

OTHER_BASE = re.compile(r"[-+]?0\w+|.*:.*")  # of a number in YAML 1.1: 8, 16, 2 or 60


def read(path: Path) -> dict:
    """Keys and values of a YAML file; raises InputError with the line of what is wrong."""
    try:
        loader = yaml.SafeLoader(Path(path).read_text(encoding="utf-8"))
        if node := loader.get_single_node():
            _value(node, loader)
        data = loader.construct_document(node) if node else None
    except (OSError, UnicodeDecodeError) as error:
        names = [each.name for each in Path(path).parent.glob("*")]
        hint = (
            did_you_mean(Path(path).name, names, "") if isinstance(error, FileNotFoundError) else ""
        )
        raise InputError(f"{path}: cannot read it ({reason(error)}){hint}.") from None
    except RecursionError:
        raise InputError(
            f"{path}: values are nested too deep, or an alias contains itself."
        ) from None
    except yaml.reader.ReaderError as error:
        raise InputError(f"{path}: it holds the character {chr(error.character)!r}.") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        words = f"it is not valid YAML ({error.problem})"
        words = error.problem if isinstance(error, _Refused) else words
        raise InputError(f"{path}, line {mark.line + 1}: {words}.") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: it must hold keys with values, see config/paper.yaml.")
    return data


class _Refused(yaml.MarkedYAMLError):
    """Valid YAML that no configuration needs, or that it reads as something else than it looks."""

    def __init__(self, node: yaml.Node, words: str):
        super().__init__(problem=words, problem_mark=node.start_mark)


def _value(node: yaml.Node, loader: yaml.SafeLoader):
    """Value of a scalar node, None of a list or a group."""
    if isinstance(node, yaml.ScalarNode):
        return _scalar(node, loader)
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _value(item, loader)
        return None
    lines = {}  # of keys: YAML would let the last of equal ones win
    for key_node, value_node in node.value:
        key = _value(key_node, loader)
        _value(value_node, loader)
        if isinstance(key, bool):
            words = f"YAML reads the key {key_node.value} as a truth value"
            raise _Refused(key_node, f"{words}; use another name, or quotes")
        if key in lines:
            raise _Refused(key_node, f"{key!r} is a key here and in line {lines[key]}; remove one")
        lines[key] = key_node.start_mark.line + 1
    return None


def _scalar(node: yaml.ScalarNode, loader: yaml.SafeLoader):
    kind, text = node.tag.rpartition(":")[2], node.value
    if kind == "merge":
        return text
    if kind == "timestamp":
        raise _Refused(node, f"YAML reads {text[:40]!r} as a date; put it in quotes")
    try:
        value = digits = loader.construct_object(node)
    except (AttributeError, LookupError, OverflowError, TypeError, ValueError):
        raise _Refused(node, f"{text[:40]!r} is no valid {kind}") from None
    if kind in ("int", "float") and OTHER_BASE.fullmatch(text):
        with suppress(ValueError):
            digits = int(text)
        raise _Refused(node, f"YAML reads {text[:40]} as {value}; write {digits}, or quotes")
    return value
