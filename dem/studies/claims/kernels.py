"""Compile what the runs of the design need, before many processes do."""

from itertools import product

from dem.experiment.config import Sweep
from dem.experiment.warmup import compile_kernels
from dem.studies.claims.plan import Choice

VARIANTS = ("ellipse.contact", "ellipse.curvature")  # values that select other machine code


def variants(sweep: Sweep) -> list[dict]:
    """Values of the section ellipse of all runs of the study."""
    factors = sweep.claims.sensitivity.factors
    found = []
    for path in VARIANTS:
        name, factor = path.split(".")[1], factors.get(path)
        own = getattr(sweep.ellipse, name)
        values = dict.fromkeys([own, *(factor.different if isinstance(factor, Choice) else ())])
        found.append([{name: value} for value in values])
    return [one | other for one, other in product(*found)]


def compile_all(sweep: Sweep) -> None:
    """One run of each kind of granule and variant."""
    kinds = {section.kind: label for label, section in reversed(sweep.shapes.items())}
    for kind, label in kinds.items():
        for values in variants(sweep) if kind == "ellipse" else [{}]:
            ellipse = sweep.ellipse.model_copy(update=values)
            compile_kernels(sweep.model_copy(update={"ellipse": ellipse}), label)
