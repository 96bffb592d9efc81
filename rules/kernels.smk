"""Compile the kernels of each kind of granule once, before many processes need them.

REQUIRED INPUTS
    none; the machine code itself is kept in the cache folder of dem.base.sources
OUTPUTS
    {RESULTS}/kernels/{kind}.done
"""

# the first shape of each kind, so that a further shape does not compile (and run) all again
SHAPE_OF_KIND = {section.kind: label for label, section in reversed(SWEEP.shapes.items())}


def features(kind):
    """What the scenes of this sweep have or lack, which selects the code to compile."""
    ellipse = SWEEP.ellipse.model_dump() if kind == "ellipse" else {}
    friction = [value > 0 for value in SWEEP.friction.model_dump().values()]
    return [*friction, SWEEP.material.restitution < 1, SWEEP.gravity > 0, *ellipse.values()]


rule kernels:
    message:
        "Compile the kernels of the {wildcards.kind}"
    output:
        touch(RESULTS + "/kernels/{kind}.done"),
    params:
        code=lambda w: code_of("experiment.warmup", shapes=[SHAPE_OF_KIND[w.kind]]),
        features=lambda w: features(w.kind),
        shape=lambda w: SHAPE_OF_KIND[w.kind],
    log:
        RESULTS + "/logs/kernels/{kind}.log",
    benchmark:
        RESULTS + "/benchmarks/kernels/{kind}.tsv"
    shell:
        "dem compile --config {CONFIG} --shape {params.shape} 2> {log}"


def kernels_of(wildcards):
    """The mark that the kernels of this shape's kind are compiled."""
    return f"{RESULTS}/kernels/{SWEEP.shapes[wildcards.shape].kind}.done"
