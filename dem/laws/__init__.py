"""The laws of contacts, one file each, which says its class at its top: LAW = "Hertz". A new law is a new file.

In: overlaps (m), radii (m) and moduli (Pa) of those that touch. Out: what dem.laws.protocol lists, for
the kernels and for Python. `dem.check_law` says what is wrong with a law. Laws in files of a user's own:
dem.base.plugins.
"""

from pathlib import Path

from dem.base.declarations import definitions, described
from dem.base.errors import InputError
from dem.base.plugins import find, load

HOW = "docs/howto/law.md"
LAWS = {name: table["LAW"] for name, table in described(Path(__file__).parent, "LAW").items()}


def file_of(name: str, beside: str | None = None) -> Path:
    """The file of a law of this name, of the package or in the folder `beside`; raises InputError."""
    if name in LAWS:
        return Path(__file__).with_name(f"{name}.py")
    file, last = find("law", name, beside, tuple(LAWS)), name.rpartition(".")[2]
    if last not in (classes := definitions(file)):
        raise InputError(
            f"law is {name!r}; {file} has no class {last}; it defines {', '.join(classes) or 'none'}."
        )
    return file


def law_of(name: str, beside: str | None = None) -> type:
    """The class of a law; the file of a user's own runs here, and nowhere else. Raises InputError."""
    file, last = file_of(name, beside), LAWS.get(name, name.rpartition(".")[2])
    law = getattr(load(file), last)
    if not hasattr(law, "dashpot"):  # which dem.laws.protocol gives to each law
        raise InputError(f"{file}: {last} is no law; let it answer the kernels, see {HOW}.")
    return law
