"""YAML files: a regular file of UTF-8 text in, plain values out, one sentence for anything else."""

import re
import stat
from contextlib import suppress
from pathlib import Path

import yaml

from dem.base.errors import InputError
from dem.base.files import reason
from dem.base.hints import of_missing_file

LARGEST = 2_000_000  # bytes of a file
DEEPEST = 20  # groups and lists within each other
REPEATED = 10_000  # values that aliases may repeat; ten aliases ten deep would be 10^10
OTHER_BASE = re.compile(r"[-+]?0\w+|.*:.*")  # of a number in YAML 1.1: 8, 16, 2 or 60
TOO_DEEP = f"values are nested more than {DEEPEST} deep, or an alias contains itself"


def read(path: Path) -> dict:
    """Keys and values of a YAML file; raises InputError with the line of what is wrong."""
    text = _text(Path(path))
    try:
        loader = yaml.SafeLoader(text)
        if node := loader.get_single_node():
            _check(node, path, loader, [len(text) + REPEATED])
        data = loader.construct_document(node) if node else None
    except RecursionError:
        raise _fault(path, loader.line + 1, TOO_DEEP) from None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        raise _fault(path, line, f"the character {chr(error.character)!r} is not allowed") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        raise _fault(path, mark.line + 1, f"it is not valid YAML ({error.problem})") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: it must hold keys with values, see config/paper.yaml.")
    return data


def _fault(path, line: int, words: str) -> InputError:
    return InputError(f"{path}, line {line}: {words}.")


def _text(path: Path) -> str:
    """Text of a regular file; a pipe or a device could keep a reader waiting for ever."""
    try:
        status = path.stat()
        whole = stat.S_ISREG(status.st_mode) and status.st_size <= LARGEST
        data = path.read_bytes() if whole else b""
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        hint = of_missing_file(path) if isinstance(error, FileNotFoundError) else ""
        raise InputError(f"{path}: cannot read it ({reason(error)}){hint}.") from None
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: it is not a regular file; name a YAML file.")
    if not whole:
        size = f"{status.st_size:,}"
        raise InputError(f"{path}: it has {size} bytes; it must have at most {LARGEST:,}.")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        byte = data[error.start]
        raise _fault(path, line, f"byte 0x{byte:02x} is not UTF-8; save it as UTF-8") from None


def _check(node: yaml.Node, path, loader: yaml.SafeLoader, left: list[int], depth: int = 0) -> None:
    """Refuse what YAML allows and no configuration needs. left: values that there may still be, those
    of aliases counted each time; a text has no more of them than characters."""
    left[0] -= 1
    line = node.start_mark.line + 1
    if depth >= DEEPEST:
        raise _fault(path, line, TOO_DEEP)
    if left[0] < 0:
        raise _fault(path, line, f"aliases repeat more than {REPEATED:,} values; write them out")
    if isinstance(node, yaml.ScalarNode):
        _construct(node, path, loader)
        return
    lines = {}  # of keys: YAML would let the last of equal ones win
    for each in node.value:
        for inner in each if isinstance(each, tuple) else (each,):
            _check(inner, path, loader, left, depth + 1)
        if isinstance(each, tuple) and isinstance(own := each[0], yaml.ScalarNode):
            key, words = _construct(own, path, loader), ""
            if key in lines:
                words = f"{key!r} is a key here and in line {lines[key]}; remove one"
            elif isinstance(key, bool):
                words = f"YAML reads the key {own.value} as a truth value; use another name, or quotes"
            if words:
                raise _fault(path, own.start_mark.line + 1, words)
            lines[key] = own.start_mark.line + 1


def _construct(node: yaml.ScalarNode, path, loader: yaml.SafeLoader):
    """The value of a node that holds no others; what YAML reads as something else than it looks is a fault."""
    line, kind, text = node.start_mark.line + 1, node.tag.rpartition(":")[2], node.value
    if kind == "merge":
        return text
    if kind == "timestamp":
        raise _fault(path, line, f"YAML reads {text[:40]!r} as a date; put it in quotes")
    try:
        value = plain = loader.construct_object(node)
    except (AttributeError, LookupError, OverflowError, TypeError, ValueError):
        raise _fault(path, line, f"{text[:40]!r} is no valid {kind}") from None
    if kind in ("int", "float") and OTHER_BASE.fullmatch(text):
        with suppress(ValueError):
            plain = int(text)
        raise _fault(path, line, f"YAML reads {text[:40]} as {value}; write {plain}, or quotes")
    return value
