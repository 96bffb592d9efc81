"""Draw the figures of a folder in one process; those stay that the same code drew of the same results.

REQUIRED INPUTS
    {RESULTS}/drag.nc, snapshots.nc, onset.nc, shear.nc or the file of a study: as each figure says
OUTPUTS
    {RESULTS}/figures/{figure}.svg, {RESULTS}/figures/{figure}.png
"""


def shown(name, folder):
    """The picture of a figure, with its caption in the report of Snakemake."""
    labels = {"figure": name, "shows": KNOWN_FIGURES[name].caption}
    picture = f"{folder}/figures/{name}.svg"
    return update(report(picture, category="Figures", subcategory=folder, labels=labels))


for task, (folder, names) in DRAWN.items():
    task = task.replace("/", "_")

    rule:
        name:
            f"figures_{task}"
        message:
            "Draw figures of {params.folder}"
        input:
            sorted({f"{folder}/{KNOWN_FIGURES[name].file}.nc" for name in names}),
        output:
            [shown(name, folder) for name in names],
            update([f"{folder}/figures/{name}.png" for name in names]),
        params:
            code=lambda w, names=names: [code_of(KNOWN_FIGURES[name].module) for name in names],
            names=",".join(names),
            folder=lambda w, input: os.path.dirname(input[0]),
            by="python -P -m studies" if REPORTED else "dem",
        log:
            f"{folder}/logs/figures_{task}.log",
        shell:
            "{params.by} figure {params.names} {params.folder:q} --changed 2> {log:q}"
