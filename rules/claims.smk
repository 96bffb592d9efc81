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
    return SWEEP.claims.model_dump_json(include=set(keys)) if SWEEP.claims else ""


def needs_jamming(wildcards):
    from dem.studies.claims.trials import NEED_JAMMING

    return jamming_files() if wildcards.part in NEED_JAMMING else []


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
        code=code_of("studies.claims.kernels", shapes=SWEEP.shapes),
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
        kernels=CLAIMS_FOLDER + "/kernels.done",
    output:
        CLAIMS_FOLDER + "/jamming/{shape}.nc",
    params:
        code=code_of("studies.claims.jamming", "studies.claims.beds", shapes=SWEEP.shapes),
        plan=claims_plan("first_seed", "jamming", "ratios", "scaling"),
        sweep=physics("record", "material", "cases"),
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
        kernels=CLAIMS_FOLDER + "/kernels.done",
        jamming=needs_jamming,
    output:
        CLAIMS_FOLDER + "/runs/{part}/{group}.nc",
    params:
        code=code_of("studies.claims.runs", shapes=SWEEP.shapes),
        plan=lambda w: claims_plan("first_seed", "group", w.part),
        sweep=physics(),
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
    output:
        RESULTS + "/claims.nc",
    params:
        code=code_of("studies.claims.layout"),
    log:
        RESULTS + "/logs/claims/combine.log",
    shell:
        "dem claims combine -o {output} {input.parts} 2> {log}"
