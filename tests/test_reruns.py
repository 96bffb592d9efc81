"""What the workflow makes again after an edit or another value: a table, told by dry runs.

In a copy of the repository where all results of all studies are there, as empty files that
Snakemake is told to take for its own.
"""

import os

import pytest
from test_workflow import SMOKE, copy, environment, planned, snakemake  # noqa: F401 copy: a fixture

TARGETS = ("all", "accuracy", "stability", "claims", "benchmark")
STUDIES = {
    "accuracy_contacts", "accuracy_steps", "accuracy_drag", "accuracy_replicates",
    "stability_part", "claims_jamming", "claims_runs", "measure",
}  # fmt: skip
RUNS = {"kernels", "pack", "simulate", "claims_kernels", *STUDIES}
RESULTS = {"combine", "flow", "figure"}
JOINED = {"accuracy_combine", "stability_join", "claims_combine", "table"}
LINE = "\nEDITED = True\n"


@pytest.fixture(scope="module")
def made(copy):  # noqa: F811
    """The copy with a file for each result."""
    listed = snakemake(copy, *TARGETS, "-c2", "--summary").stdout.splitlines()[1:]
    for name in (line.partition("\t")[0] for line in listed):
        path = copy / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    run = snakemake(copy, *TARGETS, "-c2", "--forceall", "--touch")
    assert run.returncode == 0, run.stderr
    return copy


def again(folder, configfile=SMOKE) -> dict[str, int]:
    """Number of jobs of each rule that would run, without those that only gather files."""
    jobs = planned(folder, *TARGETS, configfile=configfile)
    return {rule: count for rule, count in jobs.items() if rule not in TARGETS}


def test_nothing_is_made_twice(made):
    assert again(made) == {}


EDITS = {
    "a comment": ("dem/contacts/loops.py", "\n# edited\n", set()),
    "an error sentence": (
        "dem/experiment/config.py", ("it must not be negative.", "it must be positive or zero."),
        set(),
    ),
    "a shape that the sweep has not": ("dem/shapes/superellipse.py", LINE, set()),
    "one more shape": (
        "dem/shapes/kinds.toml", '\ntriangle = { where = "dem.shapes.triangle.Triangle" }\n', set(),
    ),
    "the command line": ("dem/cli/app.py", LINE, set()),
    "the style of figures": ("dem/figures/style.py", LINE, {"figure"}),
    "one figure": ("dem/figures/figure13.py", LINE, {"figure"}),
    "sentences of the claims": (
        "dem/studies/claims/sentences.py", LINE, {"table", "figure"},
    ),
    "what is done with the runs": ("dem/sweep/combine.py", LINE, RESULTS | JOINED),
    "a kernel": ("dem/contacts/loops.py", LINE, RUNS | RESULTS | JOINED),
}  # fmt: skip


@pytest.mark.parametrize("edit", EDITS)
def test_an_edit_makes_again_what_depends_on_it(made, edit):
    name, change, rules = EDITS[edit]
    path = made / name
    text, stamp = path.read_text(), path.stat()
    path.write_text(text.replace(*change) if isinstance(change, tuple) else text + change)
    jobs = again(made)
    path.write_text(text)
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
    assert set(jobs) == rules


# (what config/smoke.yaml says, what is put instead): jobs of each rule
SWEEP = {"combine": 1, "flow": 1, "figure": 9}
VALUES = {
    "one more seed": (("seeds: [1, 2]", "seeds: [1, 2, 3]"), SWEEP | {"pack": 4, "simulate": 5}),
    "seeds a job": (("seeds: [1, 2]", "seeds: [1, 2]\nbatch: 100"), SWEEP | {"batch": 4}),
    "runs of the claims a job": (
        ("group: 40", "group: 20"),
        {"claims_runs": 5, "claims_combine": 1, "table": 1, "figure": 5},
    ),
    "window": (
        ("window: [0.4e-3,", "window: [0.5e-3,"),
        {
            "combine": 1, "flow": 1, "accuracy_drag": 3, "accuracy_replicates": 2,
            "accuracy_combine": 1, "claims_runs": 5, "claims_combine": 1, "table": 2, "figure": 18,
        },
    ),
    "friction": (
        ("granule: 0.3", "granule: 0.31"),
        {
            "simulate": 10, "combine": 1, "flow": 1, "figure": 21, "table": 4, "measure": 1,
            "accuracy_drag": 3, "accuracy_replicates": 2, "accuracy_steps": 1,
            "accuracy_combine": 1, "stability_part": 10, "stability_join": 1,
            "claims_jamming": 4, "claims_runs": 5, "claims_combine": 1,
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize("value", VALUES)
def test_a_value_makes_again_what_reads_it(made, value):
    change, jobs = VALUES[value]
    text = (made / SMOKE).read_text()
    assert text.count(change[0]) == 1
    (made / "config/other.yaml").write_text(text.replace(*change))
    assert again(made, "config/other.yaml") == jobs
