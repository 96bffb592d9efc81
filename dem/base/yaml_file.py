"""YAML files: a regular file of UTF-8 text in, plain values out, one sentence for anything else."""

import stat
from pathlib import Path

import yaml

from dem.base.errors import InputError
from dem.base.hints import of_missing_file

LARGEST = 2_000_000  # bytes of a file
DEEPEST = 20  # groups and lists within each other
REPEATED = 10_000  # values that aliases may repeat; ten aliases ten deep would be 10^10
LONGEST = 100  # characters of a number


def read(path: Path) -> dict:
    """Keys and values of a YAML file; raises InputError with the line of what is wrong."""
    text = _text(Path(path))
    try:
        loader = _Loader(text, path)
        try:
            data = loader.get_single_data()
        finally:
            loader.dispose()
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
        why = getattr(error, "strerror", None) or str(error)
        hint = of_missing_file(path) if isinstance(error, FileNotFoundError) else ""
        raise InputError(f"{path}: cannot read it ({why.lower()}){hint}.") from None
    if not stat.S_ISREG(status.st_mode):
        raise InputError(f"{path}: it is not a regular file; name a YAML file.")
    if path.suffix == ".nc":
        raise InputError(f"{path}: it is a file of results; name a YAML file.")
    if not whole:
        size = f"{status.st_size:,}"
        raise InputError(f"{path}: it has {size} bytes; it must have at most {LARGEST:,}.")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        byte = data[error.start]
        raise _fault(path, line, f"byte 0x{byte:02x} is not UTF-8; save it as UTF-8") from None


class _Loader(yaml.SafeLoader):
    """Refuses what YAML allows and no configuration needs, as soon as it is met."""

    def __init__(self, text, path):
        super().__init__(text)
        self.path = path
        self.depth = self.values = self.repeated = 0
        self.sizes = {}  # by node: values that it holds, those of its aliases included

    def fault(self, mark, words):
        return _fault(self.path, mark.line + 1, words)

    def compose_node(self, parent, index):
        event, before = self.peek_event(), self.values
        if self.depth >= DEEPEST:
            raise self.fault(event.start_mark, f"values are nested more than {DEEPEST} deep")
        self.depth += 1
        node = super().compose_node(parent, index)
        self.depth -= 1
        if isinstance(event, yaml.AliasEvent):
            self.repeat(event, node)
        else:
            self.values += 1
            self.sizes[node] = self.values - before
        return node

    def repeat(self, event, node):
        """Count what an alias repeats."""
        if node not in self.sizes:  # it is still being read
            raise self.fault(event.start_mark, f"the alias *{event.anchor} contains itself")
        self.values += self.sizes[node]
        self.repeated += self.sizes[node]
        if self.repeated > REPEATED:
            words = f"aliases repeat more than {REPEATED:,} values; write them out"
            raise self.fault(event.start_mark, words)

    def construct_object(self, node, deep=False):
        mark = node.start_mark
        if isinstance(node, yaml.ScalarNode) and node.tag.endswith((":int", ":float")):
            digits = len(node.value)
            if digits > LONGEST:
                raise self.fault(mark, f"a number has {digits:,} characters, more than {LONGEST}")
        try:
            return super().construct_object(node, deep)
        except InputError:
            raise
        except (AttributeError, LookupError, OverflowError, TypeError, ValueError):
            kind = node.tag.rpartition(":")[2]
            raise self.fault(mark, f"{str(node.value)[:40]!r} is no valid {kind}") from None

    def compose_mapping_node(self, anchor):
        """YAML would let the last of equal keys win, and lose the others in silence."""
        node, lines = super().compose_mapping_node(anchor), {}
        for each, _ in node.value:
            if isinstance(each, yaml.ScalarNode):  # others are refused as keys
                merge = each.tag == "tag:yaml.org,2002:merge"
                key = each.value if merge else self.construct_object(each, deep=True)
                if key in lines:
                    words = f"{key!r} is a key here and in line {lines[key]}; remove one"
                    raise self.fault(each.start_mark, words)
                lines[key] = each.start_mark.line + 1
        return node
