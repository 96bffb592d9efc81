"""Which of the paper's claims hold, and why: many runs, other assumptions, jamming, scaling.

    snakemake -j2 claims

REQUIRED INPUTS
    none; the section `claims` of the configuration
OUTPUTS
    {RESULTS}/claims/jamming/{shape}.nc, {RESULTS}/claims/runs/{part}/{group}.nc
    {RESULTS}/claims.nc, {RESULTS}/claims.txt
    {RESULTS}/figures/claims_{figure}.svg, {RESULTS}/figures/claims_{figure}.png
"""

from dem.figures import CLAIMS

CLAIMS_FOLDER = f"{RESULTS}/claims"
# what only words and figures are made with, and what only runs are
TELLING = {"report", "sentences", "compare", "evidence", "influence", "remains", "verdicts"}
MAKING = {"runs", "trials", "alignment", "changes", "design", "jamming", "beds", "kernels"}


def claims_code(names):
    return [f"dem/claims/{name}.py" for name in sorted(names)]


def jamming_files():
    from dem.studies.claims.beds import shapes

    return [f"{CLAIMS_FOLDER}/jamming/{shape}.nc" for shape in shapes(SWEEP)]


def claims_parts(wildcards):
    """The files of all jobs."""
    if SWEEP.claims is None:
        refuse("claims is missing in the configuration; see config/paper.yaml.")
    from dem.studies.claims.trials import PARTS, check_all, groups

    try:
        check_all(SWEEP)
    except InputError as error:
        refuse(error)
    runs = [f"{CLAIMS_FOLDER}/runs/{part}/{n}.nc" for part in PARTS for n in range(groups(SWEEP, part))]
    return jamming_files() + runs


def claims_plan(*keys):
    """What a job depends on in the section `claims`, as text."""
    return SWEEP.claims.model_dump_json(include={"first_seed", "group", *keys}) if SWEEP.claims else ""


def needs_jamming(wildcards):
    from dem.studies.claims.trials import NEED_JAMMING

    return jamming_files() if wildcards.part in NEED_JAMMING else []


def swept(*without):
    """What a run depends on in the rest of the configuration, as text."""
    return SWEEP.model_dump_json(exclude={"title", "results", "seeds", "accuracy", "claims", *without})


localrules:
    claims,


rule claims:
    input:
        RESULTS + "/claims.txt",
        pictures(CLAIMS),


rule claims_kernels:
    message:
        "Compile what the runs of the study need"
    output:
        touch(CLAIMS_FOLDER + "/kernels.done"),
    params:
        sources=SOURCES,
        features=lambda w: [features(kind) for kind in SHAPE_OF_KIND],
        plan=claims_plan("sensitivity"),
    log:
        RESULTS + "/logs/claims/kernels.log",
    shell:
        "dem claims compile --config {CONFIG} 2> {log}"


rule claims_jamming:
    message:
        "At which packing fraction {wildcards.shape} jam"
    input:
        code=claims_code({"jamming", "beds", "trials", "changes"}),
        kernels=CLAIMS_FOLDER + "/kernels.done",
    output:
        CLAIMS_FOLDER + "/jamming/{shape}.nc",
    params:
        sources=SOURCES,
        plan=claims_plan("jamming", "ratios", "scaling"),
        sweep=swept("record", "material", "cases"),
    priority: 10
    log:
        RESULTS + "/logs/claims/jamming/{shape}.log",
    benchmark:
        RESULTS + "/benchmarks/claims/jamming/{shape}.tsv"
    shell:
        "dem claims jamming --config {CONFIG} --shape {wildcards.shape} -o {output} 2> {log}"


rule claims_runs:
    message:
        "Runs for the claims: {wildcards.part}, group {wildcards.group}"
    input:
        code=[*claims_code(MAKING - {"jamming", "beds", "kernels"}), "dem/studies/accuracy/runs.py"],
        flow=[f"dem/flow/{name}.py" for name in ("collect", "measures", "motion")],
        kernels=CLAIMS_FOLDER + "/kernels.done",
        jamming=needs_jamming,
    output:
        CLAIMS_FOLDER + "/runs/{part}/{group}.nc",
    params:
        sources=SOURCES,
        plan=lambda w: claims_plan(w.part),
        sweep=swept(),
        jamming=lambda w, input: [f"--jamming {file}" for file in input.jamming],
    priority: 5
    log:
        RESULTS + "/logs/claims/runs/{part}/{group}.log",
    benchmark:
        RESULTS + "/benchmarks/claims/runs/{part}/{group}.tsv"
    shell:
        "dem claims runs --config {CONFIG} --part {wildcards.part} --group {wildcards.group}"
        " {params.jamming} -o {output} 2> {log}"


rule claims_combine:
    message:
        "Combine the study into {output}"
    input:
        parts=claims_parts,
        code=[*claims_code({"layout"}), "dem/sweep/study.py"],
    output:
        RESULTS + "/claims.nc",
    log:
        RESULTS + "/logs/claims/combine.log",
    shell:
        "dem claims combine -o {output} {input.parts} 2> {log}"


rule claims_table:
    message:
        "Write {output}"
    input:
        data=RESULTS + "/claims.nc",
        code=claims_code(TELLING),
    output:
        RESULTS + "/claims.txt",
    log:
        RESULTS + "/logs/claims/table.log",
    shell:
        "dem info {input.data} -o {output} 2> {log}"
