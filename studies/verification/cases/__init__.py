"""The cases, one a file; the folder is the list.

A file says its question, the closed form or published value, and how the tolerance follows, in its docstring.
It has TITLE, SOURCE, `measure() -> list[Row]`, and `plot(axes, rows)`, which draws what was measured.
"""

from pathlib import Path

NAMES = tuple(sorted(path.stem for path in Path(__file__).parent.glob("[a-z]*.py")))
