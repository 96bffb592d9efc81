"""Write README.md from its template docs/readme.md and the results in docs/data.

python docs/write_readme.py
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE.parent), str(HERE / "_ext")]
from findings import FRONT_MATTER, fill  # noqa: E402

TEMPLATE, README = HERE / "readme.md", HERE.parent / "README.md"


def filled() -> str:
    """README.md as the template and the results have it."""
    text = TEMPLATE.read_text(encoding="utf-8")
    return fill(FRONT_MATTER.sub("", text))


if __name__ == "__main__":
    README.write_text(filled(), encoding="utf-8")
