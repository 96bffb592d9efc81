"""What the workflow makes again after an edit or another value: a table, told by dry runs.

In a copy of the repository with the results of the sweep and of the claims. Those of the other
studies are empty files that Snakemake takes for its own.
"""

import shutil

import pytest
from project import needs_study, posix
from workflows import SMOKE, completed, edited, planned, snakemake

pytestmark = [posix, needs_study("accuracy", "stability", "claims", "benchmark")]
TARGETS = ("all", "accuracy", "stability", "claims", "benchmark")
LINE = "\nEDITED = True\n"


@pytest.fixture(scope="module")
def project(checkout_with_claims, tmp_path_factory):
    """A copy of the sources and of the results of sweep and claims, with a file for each result."""
    folder = tmp_path_factory.mktemp("made") / "copy"
    shutil.copytree(checkout_with_claims, folder, symlinks=True)
    lines = snakemake(folder, *TARGETS, "-c2", "--summary").stdout.splitlines()[1:]
    for line in lines:
        path = folder / line.partition("\t")[0]
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
    completed(folder, *TARGETS, "-c2", "--forceall", "--touch")
    return folder


def jobs_to_run(folder) -> dict[str, int]:
    """Number of jobs of each rule that would run, without those that only gather files."""
    jobs = planned(folder, *TARGETS)
    return {rule: count for rule, count in jobs.items() if rule not in TARGETS}


RESULTS = {"combine", "figure", "results", "table"}
HARMLESS = [
    ("dem/experiment/config.py", ("of mixtures needs", "of a mixture needs")),  # of a sentence
    ("dem/experiment/observables/heat.py", "VARIABLES = {}\n"),  # one more
    ("dem/cli/app.py", LINE),
    (SMOKE, ("title: Smoke", "batch: 3\ntitle: Smoke")),
    (
        SMOKE,
        ("  fraction: 0.84\n  size_spread: 0.2", "  size_spread: 0.2\n  fraction: 0.84"),
    ),
]
# (file, what is added, or put for what is there): rules whose jobs run, and the number of jobs of some of them
EDITS = {
    "sentences of the claims": ("studies/claims/sentences.py", LINE, {"table", "figure"}, {}),
    "a kernel": ("dem/contacts/response.py", LINE, {"batch"} | RESULTS, {}),
    "one more seed": (
        SMOKE,
        ("seed: [1, 2]", "seed: [1, 2, 3]"),
        RESULTS - {"results", "table"} | {"batch"},
        {"batch": 3},  # of new runs
    ),
    "window": (SMOKE, ("window: [0.4e-3,", "window: [0.5e-3,"), RESULTS, {}),
    "another study's sweep": (
        "studies/accuracy/smoke.yaml",
        ("seed: 1001 to 1003", "seed: 1001 to 1004"),
        RESULTS - {"combine"} | {"batch"},
        {},
    ),
}


def test_nothing_is_made_again_for_what_changes_no_result(project):
    """After edits and values that no number and no picture depends on, all of them at once."""
    with edited(project, HARMLESS):
        assert jobs_to_run(project) == {}
    assert jobs_to_run(project) == {}


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_makes_again_what_depends_on_it(project, edit):
    name, change, rules, counts = EDITS[edit]
    with edited(project, [(name, change)]):
        jobs = jobs_to_run(project)
    assert set(jobs) == rules and counts.items() <= jobs.items()
