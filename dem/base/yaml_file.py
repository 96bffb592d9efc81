"""YAML files: UTF-8 text in, plain values out, one sentence with its line for anything else."""

from pathlib import Path

import yaml

from dem.base.errors import InputError


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
    if not isinstance(data, dict):
        raise InputError(f"{path}: it must hold keys with values, see config/paper.yaml.")
    return data


class _Loader(yaml.SafeLoader):
    """PyYAML's, which takes the last of two equal keys, without these."""

    def compose_mapping_node(self, anchor):
        node, lines = super().compose_mapping_node(anchor), {}
        for key, _ in node.value:
            if (name := str(key.value)) in lines:
                words = f"{name!r} is a key here and in line {lines[name]}; remove one"
                raise yaml.MarkedYAMLError(problem=words, problem_mark=key.start_mark)
            lines[name] = key.start_mark.line + 1
        return node
