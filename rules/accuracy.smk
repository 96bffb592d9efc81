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


def plan_of(*keys):
    """What a job depends on in the configuration, as text."""
    return SWEEP.accuracy.model_dump_json(include=set(keys)) if SWEEP.accuracy else ""


def run_of(shape):
    """What the run of a shape depends on, with its density and the window, as text."""
    key = SWEEP.replicate(shape, SWEEP.density_of(shape), SWEEP.seeds[0]).run_key()
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
    output:
        STUDY + "/contacts.nc",
    params:
        code=code_of("studies.accuracy.contacts", "studies.accuracy.bounces"),
        plan=plan_of("size"),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/contacts.log",
    shell:
        "dem accuracy contacts --config {CONFIG} -o {output} 2> {log}"


rule accuracy_steps:
    message:
        "Time steps and integrators: error against time, alone on the computer"
    output:
        STUDY + "/steps.nc",
    params:
        code=code_of("studies.accuracy.steps"),
        plan=plan_of("size"),
        sweep=physics("record"),
    threads: workflow.cores
    log:
        RESULTS + "/logs/accuracy/steps.log",
    shell:
        "dem accuracy steps --config {CONFIG} -o {output} 2> {log}"


rule accuracy_drag:
    message:
        "Mean drag of {wildcards.shape} at many time steps, group {wildcards.group}"
    input:
        kernels=kernels_of,
    output:
        STUDY + "/drag/{shape}/{group}.nc",
    params:
        code=lambda w: code_of("studies.accuracy.runs", shapes=[w.shape]),
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
        kernels=lambda w: f"{RESULTS}/kernels/{SWEEP.shapes[SWEEP.accuracy.replicates.shape].kind}.done",
    output:
        STUDY + "/replicates/{group}.nc",
    params:
        code=lambda w: code_of("studies.accuracy.runs", shapes=[SWEEP.accuracy.replicates.shape]),
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
    output:
        RESULTS + "/accuracy.nc",
    params:
        code=code_of("studies.accuracy.files"),
    log:
        RESULTS + "/logs/accuracy/combine.log",
    shell:
        "dem accuracy combine -o {output} {input.parts} 2> {log}"
