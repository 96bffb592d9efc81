"""YAML files: UTF-8 text in, plain values out, one sentence with its line for anything else.

A plain scalar means what the core schema of YAML 1.2 says, so that 1e3 is a number. One that is
something else in YAML 1.1, by which Snakemake and others read the same file, is refused.
"""

import re
from pathlib import Path

import yaml

from dem.base.errors import InputError

DEEPEST = 64  # groups and lists within each other, and files that extend each other
LONGEST = 1000  # letters of a text
MOST = 1_000_000  # values; an alias counts wherever it is used
TOO_MUCH = f"it has more than {MOST:,} values, or they are nested more than {DEEPEST} deep or in themselves"
CORE = {
    "merge": "<<",  # not of the core schema: a group in others, by its alias
    "null": "~|null|Null|NULL|",
    "bool": "true|True|TRUE|false|False|FALSE",
    "int": "[-+]?(0|[1-9][0-9]*)|0o[0-7]+|0x[0-9a-fA-F]+",
    "float": r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
}
TAG = "tag:yaml.org,2002:"
RESOLVERS = {None: [(TAG + kind, re.compile(f"({form})$")) for kind, form in CORE.items()]}
OLD = yaml.resolver.Resolver()  # of YAML 1.1


def read(path: Path) -> dict:
    """Keys and values of a YAML file; raises InputError with the line of what is wrong."""
    try:
        data = yaml.load(Path(path).read_text(encoding="utf-8"), _Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        line = f", line {mark.line + 1}" if mark else ""
        words = " ".join(str(getattr(error, "problem", error)).split())
        raise InputError(f"{path}{line}: {words}.") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: cannot read it ({error}).") from None
    except RecursionError:
        raise InputError(f"{path}: {TOO_MUCH}.") from None
    if not isinstance(data, dict):
        raise InputError(f"{path}: it must hold keys with values, see config/paper.yaml.")
    return data


def text_of(data: dict) -> str:
    """The text of a YAML file with these values, for readers of YAML 1.1 and 1.2."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False)


class _Dumper(yaml.SafeDumper):
    yaml_implicit_resolvers = yaml.SafeDumper.yaml_implicit_resolvers | RESOLVERS


class _Loader(yaml.SafeLoader):
    """PyYAML's, which takes the last of two equal keys, without these, and within bounds."""

    yaml_implicit_resolvers = RESOLVERS

    def get_single_node(self):
        root = super().get_single_node()
        left, stack = MOST, [(root, 0)] if root else []
        while stack:
            node, depth = stack.pop()
            left -= 1
            if left < 0 or depth > DEEPEST:
                _refuse(node, TOO_MUCH)
            if isinstance(node, yaml.CollectionNode):
                groups = node.value if isinstance(node, yaml.MappingNode) else [node.value]
                stack += [(part, depth + 1) for group in groups for part in group]
        return root

    def compose_mapping_node(self, anchor):
        node, lines = super().compose_mapping_node(anchor), {}
        for key, _ in node.value:
            if (name := str(key.value)) in lines:
                _refuse(key, f"{name!r} is a key here and in line {lines[name]}; remove one")
            lines[name] = key.start_mark.line + 1
        return node

    def compose_scalar_node(self, anchor):
        node = super().compose_scalar_node(anchor)
        text = node.value
        if len(text) > LONGEST or self.NON_PRINTABLE.search(text):
            words = f"it must have at most {LONGEST:,} letters, all of them printable"
            _refuse(node, f"a text is {text[:40]!a}; {words}")
        new, old = (tags.resolve(yaml.ScalarNode, text, (True, False)) for tags in (self, OLD))
        if node.style is None and old not in (new, f"{TAG}str"):
            number = f"{int(text)}, or " if new == f"{TAG}float" else ""  # zeros in front
            _refuse(node, f"{text} means another value in YAML 1.1; write {number}'{text}'")
        return node


def _refuse(node, words):
    raise yaml.MarkedYAMLError(problem=words, problem_mark=node.start_mark)
