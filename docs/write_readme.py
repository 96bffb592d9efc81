"""Write README.md from its template docs/readme.md and the results in docs/data.

python docs/write_readme.py
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))
from findings import fill  # noqa: E402

TEMPLATE, README = HERE / "readme.md", HERE.parent / "README.md"


def filled() -> str:
    """README.md as the template and the results have it."""
    text = TEMPLATE.read_text(encoding="utf-8")
    return fill(re.sub(r"\A---\n.*?\n---\n+", "", text, flags=re.S))  # front matter is not shown


if __name__ == "__main__":
    README.write_text(filled(), encoding="utf-8")
