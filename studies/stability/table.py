"""stability.nc: the energy ledger of the runs of a sweep, beside the catalogue and the linearised beds.

The block `map` varies shape, stiffness, restitution and time step, the block `paper` cases.
"""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.io.dataset import global_attributes, write
from dem.sweep.config import Sweep
from dem.sweep.expand import Block
from dem.sweep.state import SweepState
from studies.common.table import origin, parts, rows, wanted_of
from studies.stability.layout import MAP, VARIABLES

AXES = {
    "map": ("shape", "material_young_modulus", "material_restitution", "numerics_step_fraction"),
    "paper": ("case",),
}


def blocks_of(sweep: Sweep) -> dict[str, Block]:
    """The blocks by name; raises InputError where they are not those of the study."""
    if set(sweep.blocks) != set(AXES):
        raise InputError(
            f"sweep.blocks must be {' and '.join(AXES)}; see studies/stability/sweep.yaml."
        )
    blocks = {name: sweep.block(name) for name in AXES}
    for name, dims in AXES.items():
        block = blocks[name]
        if block.dims != (*dims, "seed") or block.shape[-1] != 1:
            raise InputError(
                f"sweep.blocks.{name} varies {', '.join(block.dims)}; it must vary {', '.join(dims)} in "
                "this order, and have one seed."
            )
        if "ledger" not in block.first.configuration.record.observables:
            raise InputError(
                f"record.observables of sweep.blocks.{name} lacks ledger; the study needs it."
            )
    return blocks


def energy_map(paths: list[Path], block: Block, young_modulus: float) -> dict:
    """Worst residual of each run of the map; NaN where it failed."""
    residual = np.full(block.shape, np.nan)
    for ids, values in rows(paths, ("ledger_residual", "failure"), wanted_of([block])):
        for run, along in zip(ids, values["ledger_residual"], strict=True):
            for place in block.points[run]:
                residual[place] = along.max()  # NaN if any is
    shape, modulus, *others = (np.array(axis.coordinate) for axis in block.axes[:-1])
    axes = shape, modulus / young_modulus, *others
    return dict(zip(MAP, axes, strict=True)) | {"map_residual": residual[..., 0]}


def paper(paths: list[Path], block: Block) -> dict:
    """Residual of each case along the stroke, after its start."""
    own = block.first.configuration
    moved = np.linspace(0.0, own.cylinder.stroke, own.record.snapshots)
    residual = np.full((block.shape[0], len(moved)), np.nan)
    for ids, values in rows(paths, ("ledger_residual",), wanted_of([block])):
        for run, along in zip(ids, values["ledger_residual"], strict=True):
            for case, _ in block.points[run]:
                residual[case] = along
    return {
        "paper_case": np.array(block.axes[0].coordinate),
        "paper_displacement": moved[1:],
        "paper_residual": residual[:, 1:],
    }


def write_study(path: Path, state: SweepState, files: list[Path]) -> None:
    """Write stability.nc from the batches of a sweep and what the catalogue and the limits wrote."""
    sweep, blocks = state.sweep, blocks_of(state.sweep)
    batches = {name: state.files(name) for name in blocks}
    values = (
        parts(files, VARIABLES)
        | energy_map(batches["map"], blocks["map"], sweep.material.young_modulus)
        | paper(batches["paper"], blocks["paper"])
    )
    absent = [name for name in VARIABLES if name not in values]
    if absent:
        raise InputError(f"the parts lack {absent[0]}; give those of catalogue and of limits.")
    attrs = global_attributes(
        f"{sweep.title}: stiff and extreme cases",
        "python -m studies stability table",
        **origin([*files, *batches["map"], *batches["paper"]]),
        default_fraction=sweep.numerics.step_fraction,
    )
    write(path, values, attrs, VARIABLES)
