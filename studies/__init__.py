"""Questions with runs of their own, each a folder with all that is about it.

page.md       what was found, a page of the documentation
findings.py   each number and table of it, a method each; `python -m studies NAME info` prints them
sweep.yaml    the runs; smoke.yaml: the smallest ones that show that it works
rules.smk     targets of Snakemake
verbs.py      `python -m studies NAME VERB`
figures/      as dem/figures
NAME.nc       what was released; where a sweep does not write it by itself, its layout is in layout.py
tests/        of this folder alone

A study imports dem and studies.common, and no other study. Remove a folder, and it is gone.
"""

from pathlib import Path

from dem.base import sources

HERE = Path(__file__).parent
NAMES = tuple(
    sorted(path.parent.name for path in HERE.glob("*/findings.py") if path.parent.name != "common")
)
sources.ROOTS["studies"] = HERE
