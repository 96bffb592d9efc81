"""What the docstrings of the public names promise: examples that run, names, units and errors."""

import doctest
import inspect
import operator
import re

import pytest

import dem

HOW = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
# of a public module, its functions
NAMES = [
    each
    for name in dem.__all__
    for each in (
        [f"{name}.{function}" for function in getattr(dem, name).__all__]
        if inspect.ismodule(getattr(dem, name))
        else [name]
    )
]
# of numpydoc.validate: sections in order, one line of summary that ends with a full stop, and the
# parameters of the signature, each with a type and a description
CODES = {
    "GL03",
    "GL06",
    "GL07",
    "GL08",
    "SS01",
    "SS02",
    "SS03",
    "SS06",
    "PR01",
    "PR02",
    "PR03",
    "PR04",
    "PR05",
    "PR07",
    "PR10",
    "RT01",
    "YD01",
}
NUMBER = re.compile(r"\b(float|int|ndarray|array_like)\b")
UNIT = r"(m|m/s2?|s|rad|rad/s|N|N m|N s|N s/m|J|Pa|kg|kg/m3|SI units)"
STATED = re.compile(rf"\({UNIT}\)|\bin {UNIT}\b|without unit")


def examples(name):
    """Doctests by qualified name: of a function, or of a class and its members."""
    thing = operator.attrgetter(name)(dem)
    finder = doctest.DocTestFinder(recurse=inspect.isclass(thing))
    found = finder.find(thing, name, inspect.getmodule(thing), globs={})
    return {test.name: test for test in found if test.examples}


def members(name):
    """Qualified names of the public methods and properties that a class of the package defines."""
    thing = operator.attrgetter(name)(dem)
    own = vars(thing).items() if inspect.isclass(thing) else ()
    return [
        f"{name}.{key}"
        for key, member in own
        if not key.startswith("_") and is_own(member, f"{name}.{key}")
    ]


def is_own(member, name):
    """Whether a member is a property or method, and not a field or a function of another module."""
    return isinstance(member, property | classmethod) or getattr(member, "__qualname__", "") == name


@pytest.mark.parametrize("name", NAMES)
def test_examples_run(name, monkeypatch, request):
    """Every public name has an example, and it prints what it says."""
    monkeypatch.chdir(request.config.rootpath)
    said = []
    tests = examples(name)
    for test in tests.values():
        doctest.DocTestRunner(optionflags=HOW).run(test, out=said.append)
    assert not said, "".join(said)
    assert name in tests, f"{name} has no example"


def test_every_member_of_a_simulation_has_an_example():
    """In its own docstring, in that of the class or of another member."""
    source = "".join(each.source for t in examples("Simulation").values() for each in t.examples)
    for name in members("Simulation"):
        used = name.replace("Simulation.", r"\brun\.")
        assert re.search(used + r"\b", source), f"{name} has no example"


@pytest.mark.parametrize("name", NAMES)
def test_docstrings_are_numpydoc(name):
    """Parameters are those of the signature, numbers and arrays have units, errors are listed."""
    docscrape = pytest.importorskip("numpydoc.docscrape")
    from numpydoc import validate

    said = []
    for qualified in [name, *members(name)]:
        thing = operator.attrgetter(qualified)(dem)
        public = operator.attrgetter(name)(dem)
        path = f"{public.__module__}.{qualified.removeprefix('plot.')}"
        parsed = docscrape.NumpyDocString(inspect.getdoc(thing))
        said += [
            f"{qualified}: {words}"
            for code, words in validate.validate(path)["errors"]
            if code in CODES and not (code == "PR01" and parsed["Attributes"])
        ]
        for section in ("Parameters", "Attributes", "Returns"):
            for entry in parsed[section]:
                if NUMBER.search(entry.type) and not STATED.search(" ".join(entry.desc)):
                    said.append(f"{qualified}: {entry.name} has no unit")
        if raises(thing) and not parsed["Raises"]:
            said.append(f"{qualified}: it raises errors and does not say so")
    assert not said, "\n".join(said)


def raises(thing):
    """Whether the arguments are checked, or the source raises an error."""
    if inspect.isclass(thing):
        thing = thing.__new__ if issubclass(thing, tuple) else thing.__init__
    if not inspect.isroutine(thing):
        return False
    checks = hasattr(thing, "__wrapped__")
    try:
        source = inspect.getsource(inspect.unwrap(thing))
    except (OSError, TypeError):  # made by namedtuple or dataclass
        return checks
    return checks or bool(re.search(r"\braise |\brefuse\(|\b_fail\(", source))
