"""Questions with runs of their own, each a folder with all that is about it.

page.md       what came out, a page of the documentation
sweep.yaml    the runs; smoke.yaml: the smallest ones that show that it works
results.py    the file of results NAME.nc and what makes it, where the sweep alone does not;
              see studies/common/results.py
findings.py   each number and table of the page; `python -m studies NAME info` prints them
figures/      as dem/figures
verbs.py      VERBS, functions that `python -m studies NAME` has beside `make` and `info`
NAME.nc       the released file
tests/        of this folder alone

A large question has parts, each a folder in its folder. A study imports dem and studies.common, and
no other study. Remove a folder, and it is gone.
"""

from pathlib import Path

HERE = Path(__file__).parent
FOLDERS = {
    path.parent.name: path.parent
    for path in sorted(HERE.rglob("findings.py"))
    if path.parent.name != "common"
}
NAMES = tuple(sorted(FOLDERS))


def package_of(name: str) -> str:
    """The package of a study: studies.accuracy.budget of budget."""
    return ".".join(("studies", *FOLDERS[name].relative_to(HERE).parts))


def has_sweep(name: str) -> bool:
    """Whether a study has a sweep of its own."""
    return (FOLDERS[name] / "sweep.yaml").is_file()


def sweep_of(name: str) -> Path:
    """The sweep that a study reads: of its folder, or else that of the paper."""
    return FOLDERS[name] / "sweep.yaml" if has_sweep(name) else HERE.parent / "config/paper.yaml"
