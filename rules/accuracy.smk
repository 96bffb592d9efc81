"""Error against run time: contacts, integrators, the mean drag; not part of the default.

    snakemake -j2 accuracy

What is timed runs alone on the computer, the rest side by side.

REQUIRED INPUTS
    none; the section `accuracy` of the configuration
OUTPUTS
    {RESULTS}/accuracy/contacts.nc, steps.nc, drag/{shape}/{group}.nc, replicates/{group}.nc
    {RESULTS}/accuracy.nc, {RESULTS}/accuracy.txt
    {RESULTS}/figures/accuracy_{figure}.svg, {RESULTS}/figures/accuracy_{figure}.png
"""

from dem.studies.accuracy.plan import density_of
from dem.figures import ACCURACY

STUDY = f"{RESULTS}/accuracy"


def accuracy_parts(wildcards):
    """The files of all jobs."""
    plan = SWEEP.accuracy
    if plan is None:
        refuse("accuracy is missing in the configuration; see config/paper.yaml.")
    drag = [
        f"{STUDY}/drag/{shape}/{group}.nc"
        for shape in plan.steps
        for group in range(plan.groups(plan.most(shape)))
    ]
    groups = range(plan.groups(plan.replicates.seeds))
    replicates = [f"{STUDY}/replicates/{group}.nc" for group in groups]
    return [f"{STUDY}/contacts.nc", f"{STUDY}/steps.nc", *drag, *replicates]


def study_code(*names):
    return [f"dem/accuracy/{name}.py" for name in names]


def plan_of(*keys):
    """What a job depends on in the configuration, as text."""
    return SWEEP.accuracy.model_dump_json(include=set(keys)) if SWEEP.accuracy else ""


def run_of(shape):
    """What the run of a shape depends on, with its density and the window, as text."""
    key = SWEEP.replicate(shape, density_of(SWEEP, shape), SWEEP.seeds[0]).run_key()
    return f"{key} {SWEEP.record.window}"


localrules:
    accuracy,


rule accuracy:
    input:
        RESULTS + "/accuracy.txt",
        pictures(ACCURACY),


rule accuracy_contacts:
    message:
        "Contacts of ellipses: error against time, alone on the computer"
    input:
        code=study_code("contacts", "bounces", "pairs", "solvers", "definitions", "trials"),
    output:
        STUDY + "/contacts.nc",
    params:
        sources=SOURCES,
        plan=plan_of("size"),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/contacts.log",
    shell:
        "dem accuracy contacts --config {CONFIG} -o {output} 2> {log}"


rule accuracy_steps:
    message:
        "Time steps and integrators: error against time, alone on the computer"
    input:
        code=study_code("steps", "integrators", "collisions", "step_runs"),
        peers="dem/studies/peers/lammps.py",
    output:
        STUDY + "/steps.nc",
    params:
        sources=SOURCES,
        plan=plan_of("size"),
        sweep=SWEEP.model_dump_json(exclude={"title", "results", "record", "accuracy"}),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/steps.log",
    shell:
        "dem accuracy steps --config {CONFIG} -o {output} 2> {log}"


rule accuracy_drag:
    message:
        "Mean drag of {wildcards.shape} at many time steps, group {wildcards.group}"
    input:
        code=study_code("runs"),
        kernels=kernels_of,
    output:
        STUDY + "/drag/{shape}/{group}.nc",
    params:
        sources=SOURCES,
        plan=lambda w: str(SWEEP.accuracy.share(int(w.group), w.shape)),
        run=lambda w: run_of(w.shape),
    log:
        RESULTS + "/logs/accuracy/drag/{shape}/{group}.log",
    benchmark:
        RESULTS + "/benchmarks/accuracy/drag/{shape}/{group}.tsv"
    shell:
        "dem accuracy drag --config {CONFIG} --shape {wildcards.shape} --group {wildcards.group}"
        " -o {output} 2> {log}"


rule accuracy_replicates:
    message:
        "Many replicates, group {wildcards.group}"
    input:
        code=study_code("runs"),
        kernels=lambda w: f"{RESULTS}/kernels/{SWEEP.shapes[SWEEP.accuracy.replicates.shape].kind}.done",
    output:
        STUDY + "/replicates/{group}.nc",
    params:
        sources=SOURCES,
        plan=plan_of("replicates", "first_seed", "group"),
        run=lambda w: run_of(SWEEP.accuracy.replicates.shape),
    log:
        RESULTS + "/logs/accuracy/replicates/{group}.log",
    benchmark:
        RESULTS + "/benchmarks/accuracy/replicates/{group}.tsv"
    shell:
        "dem accuracy replicates --config {CONFIG} --group {wildcards.group} -o {output} 2> {log}"


rule accuracy_combine:
    message:
        "Combine the study into {output}"
    input:
        parts=accuracy_parts,
        code=study_code("files", "layout", "layout_contacts", "layout_steps"),
    output:
        RESULTS + "/accuracy.nc",
    log:
        RESULTS + "/logs/accuracy/combine.log",
    shell:
        "dem accuracy combine -o {output} {input.parts} 2> {log}"


rule accuracy_table:
    message:
        "Write {output}"
    input:
        data=RESULTS + "/accuracy.nc",
        code=study_code("report", "bias", "replicates", "contacts"),
    output:
        RESULTS + "/accuracy.txt",
    log:
        RESULTS + "/logs/accuracy/table.log",
    shell:
        "dem info {input.data} -o {output} 2> {log}"
