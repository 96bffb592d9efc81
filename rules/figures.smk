"""Draw the figures and write the tables of studies, each from one file of results.

    snakemake -j2 figures          those that the files in {RESULTS} suffice for; makes no file of results

REQUIRED INPUTS
    {RESULTS}/drag.nc, flow.nc, onset.nc, shear.nc or the file of a study: see dem/figures/__init__.py
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png, {RESULTS}/{study}.txt
"""

from dem.figures import BEDS_OF, FILE_OF, STUDY_FIGURES, drawable


def pictures(names, folder=RESULTS):
    """Both files of each of some figures."""
    return expand("{folder}/figures/{figure}.{kind}", folder=folder, figure=names, kind=["svg", "png"])


def pictures_of_results(wildcards):
    if not ONLY_FIGURES:  # the rules that make results are there, and would run
        refuse("figures must be a target on the command line: snakemake -j2 figures.")
    drawn = [folder for folder, block in MAIN.folders.items() if possible(MAIN.block(block))]
    try:
        return [each for folder in drawn or [RESULTS] for each in pictures(drawable(folder), folder)]
    except InputError as error:
        refuse(error)


def data_of(wildcards):
    """The file that a figure is drawn from; of beds, that of their shapes, which is there first."""
    folder, figure = wildcards.folder, wildcards.figure
    beds = f"{folder}/flow/{BEDS_OF.get(figure)}.nc"
    if figure in BEDS_OF and not (ONLY_FIGURES and not Path(beds).is_file()):
        return beds
    return f"{folder}/{FILE_OF[figure]}.nc"


rule figure:
    message:
        "Draw {wildcards.figure}"
    input:
        data=data_of,
    output:
        update("{folder}/figures/{figure}.svg"),
        update("{folder}/figures/{figure}.png"),
    params:
        code=lambda w: code_of(f"figures.{w.figure}"),
    wildcard_constraints:
        figure="|".join(FILE_OF),
    log:
        "{folder}/logs/figures/{figure}.log",
    shell:
        "begin {output:q}; dem figure {wildcards.figure} {input.data} -o {wildcards.folder}/figures 2> {log}; end {output:q}"


rule table:
    message:
        "Write {output}"
    input:
        data=RESULTS + "/{study}.nc",
    output:
        update(RESULTS + "/{study}.txt"),
    params:
        code=lambda w: code_of("report.info", f"studies.{w.study}.report"),
    wildcard_constraints:
        study="|".join(STUDY_FIGURES),
    log:
        RESULTS + "/logs/{study}/table.log",
    shell:
        "begin {output:q}; dem info {input.data} -o {output} 2> {log}; end {output:q}"


rule figures:
    input:
        pictures_of_results,
