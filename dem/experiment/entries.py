"""The values of a configuration that may vary in a sweep."""

from typing import Any, NamedTuple, get_origin

from pydantic.fields import FieldInfo

from dem.base.refusals import section_of, unit_of

UNHASHED_KEYS = "beside", "record.window", "threads"  # that no number depends on
FIXED_KEYS = *UNHASHED_KEYS, "record.observables", "record.region"  # that cannot vary in a sweep
# names of others that cannot
NO_AXIS = "discs", "mixture", "until", "file", "path", "removed", "to"


class Entry(NamedTuple):
    """A value that may vary: its path, units (None: a text), what it is, its field of the schema."""

    path: str
    units: str | None
    about: str
    field: FieldInfo | None = None

    def __reduce__(self):
        """Without the field for another process: its checks are functions that cannot be sent."""
        return Entry, self[:3]


def entries(fields: dict[str, FieldInfo], values: Any = None, head: str = "") -> dict[str, Entry]:
    """All values of a configuration that may vary, by path; of tables the values of its labels."""
    paths = {}
    for name, field in fields.items():
        path, section = head + name, section_of(field.annotation)
        inner = values.get(name) if isinstance(values, dict) else getattr(values, name, None)
        if section and get_origin(field.annotation) is dict:
            for label in inner or ():
                paths |= entries(section.model_fields, inner[label], f"{path}.{label}.")
        elif section:
            paths |= entries(section.model_fields, inner, f"{path}.")
        elif path not in FIXED_KEYS and name not in NO_AXIS:
            unit = unit_of(field.rebuild_annotation())
            paths[path] = Entry(path, unit, field.description, field)
    return paths
