"""Draw the figures and write the tables of studies, each from one file of results.

    snakemake -j2 figures          those that the files in {RESULTS} suffice for; makes no file of results

REQUIRED INPUTS
    {RESULTS}/drag.nc, flow.nc, onset.nc, shear.nc or the file of a study: as each figure says
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png, {RESULTS}/{study}.txt
"""

from dem.figures.catalogue import drawable


def pictures_of(study):
    """Both files of each figure of a study."""
    return pictures([name for name, each in KNOWN_FIGURES.items() if each.file == study])


def pictures(names, folder=RESULTS):
    """Both files of each of some figures."""
    return expand("{folder}/figures/{figure}.{kind}", folder=folder, figure=names, kind=["svg", "png"])


def pictures_of_results(wildcards):
    if not ONLY_FIGURES:  # the rules that make results are there, and would run
        refuse("figures must be a target on the command line: snakemake -j2 figures.")
    drawn = [folder for folder, block in MAIN.folders.items() if possible(MAIN.block(block), KNOWN_FIGURES)]
    try:
        return [each for folder in drawn or [RESULTS] for each in pictures(drawable(folder, KNOWN_FIGURES), folder)]
    except InputError as error:
        refuse(error)


def data_of(wildcards):
    """The file that a figure is drawn from."""
    return f"{wildcards.folder}/{KNOWN_FIGURES[wildcards.figure].file}.nc"


rule figure:
    message:
        "Draw {wildcards.figure}"
    input:
        data=data_of,
    output:
        update("{folder}/figures/{figure}.svg"),
        update("{folder}/figures/{figure}.png"),
    params:
        by=lambda w: "dem" if w.figure in OWN_FIGURES else "study",
        code=lambda w: code_of(KNOWN_FIGURES[w.figure].module),
    wildcard_constraints:
        figure="|".join(KNOWN_FIGURES),
    log:
        "{folder}/logs/figures/{figure}.log",
    shell:
        "begin {output:q}; {params.by} figure {wildcards.figure} {input.data} -o {wildcards.folder}/figures 2> {log}; end {output:q}"


rule table:
    message:
        "Write {output}"
    input:
        data=RESULTS + "/{study}.nc",
    output:
        update(RESULTS + "/{study}.txt"),
    params:
        code=lambda w: code_of(f"studies.{w.study}.findings"),
    wildcard_constraints:
        study="|".join(REPORTED),
    log:
        RESULTS + "/logs/{study}/table.log",
    shell:
        "begin {output:q}; study {wildcards.study} info {input.data} -o {output} 2> {log}; end {output:q}"


rule figures:
    input:
        pictures_of_results,
