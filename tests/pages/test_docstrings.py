"""What the docstrings of the public names promise: examples that run, and units."""

import doctest
import inspect
import operator
import re

import pytest

import dem

HOW = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS
NAMES = [name for name in dem.__all__ if not inspect.ismodule(getattr(dem, name))]
NAMES += [f"plot.{name}" for name in dem.plot.__all__]
NUMBER = re.compile(r"\b(float|int|ndarray|array_like)\b")
UNIT = r"(m|m/s2?|s|rad|rad/s|N|N/m|N m|N m/rad|N s|N s/m|N m s|J|Pa|kg|kg m2|kg/m3|SI units)"
STATED = re.compile(rf"\({UNIT}\)|\bin {UNIT}\b|without unit")


def parts(name):
    """A public name, or a class and those of the package that it is made of."""
    thing = operator.attrgetter(name)(dem)
    classes = inspect.getmro(thing) if inspect.isclass(thing) else [thing]
    return [each for each in classes if each.__module__.startswith("dem.")]


def examples(name):
    """Doctests by qualified name: of a function, or of a class and its members."""
    doctests = []
    for each in parts(name):
        finder = doctest.DocTestFinder(recurse=inspect.isclass(each))
        doctests += finder.find(each, name, inspect.getmodule(each), globs={})
    return {test.name: test for test in doctests if test.examples}


def members(name):
    """Qualified names of the public methods and properties that a class of the package defines, without fields
    and functions of another module."""
    for each in parts(name):
        for key, member in getattr(each, "__dict__", {}).items():
            own = getattr(member, "__qualname__", "") == f"{each.__qualname__}.{key}"
            if key[0] != "_" and (own or isinstance(member, property | classmethod)):
                yield f"{name}.{key}"


@pytest.mark.parametrize("name", NAMES)
def test_help_has_types_that_can_be_read_and_an_example_that_prints_what_it_says(
    name, monkeypatch, request
):
    """One short line of types, without what checks the values."""
    monkeypatch.chdir(request.config.rootpath)
    failures = []
    tests = examples(name)
    for test in tests.values():
        doctest.DocTestRunner(optionflags=HOW).run(test, out=failures.append)
    assert not failures, "".join(failures)
    assert name in tests, f"{name} has no example"
    thing = operator.attrgetter(name)(dem)
    if not (inspect.isclass(thing) and issubclass(thing, Exception)):
        types = str(inspect.signature(thing))
        assert not re.search("Annotated|Validator|FieldInfo|Unit", types) and len(types) < 700


@pytest.mark.parametrize("name", NAMES)
def test_numbers_of_docstrings_have_units(name):
    """Those of arguments, attributes and results."""
    docscrape = pytest.importorskip("numpydoc.docscrape")
    for qualified in [name, *members(name)]:
        parsed = docscrape.NumpyDocString(inspect.getdoc(operator.attrgetter(qualified)(dem)))
        for entry in parsed["Parameters"] + parsed["Attributes"] + parsed["Returns"]:
            if NUMBER.search(entry.type):
                assert STATED.search(" ".join(entry.desc)), f"{qualified}: {entry.name}"
