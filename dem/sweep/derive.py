"""A value that follows from the results of other blocks: the experiment of these gives it."""

from typing import Any, NamedTuple

from dem.base.errors import InputError
from dem.base.messages import check_known
from dem.base.plugins import load
from dem.base.refusals import parsed, written
from dem.experiment.replicate import Replicate


class Derive(NamedTuple):
    """A value that follows from results: its key in the file, and the group there."""

    key: str
    group: dict[str, Any]


def derived(
    sweep, name: str, results: dict[str, list] | None, wanted: Derive, path: str, run: Replicate
) -> Any:
    """The value at a path of a run of a block; raises InputError where it cannot be derived.

    results: files of the blocks that it needs, open; the value of the sweep file if absent
    """
    key, options = wanted.key, dict(wanted.group)
    asked, shape = str(options.pop("derive")), options.pop("shape", None) or run.label
    check_known(f"{key} has the shape", shape, sweep.shapes, "shapes")
    blocks = {other: sweep.block(other).first.configuration.module for other in sweep.needed(name)}
    if not blocks:
        raise InputError(f"{key} derives a value; needs must name the blocks that it is from.")
    known = {each: experiment for experiment in blocks.values() for each in experiment.derives}
    check_known(f"{key}.derive is", asked, known, "those that blocks in needs give")
    experiment = known[asked]
    table, asks = experiment.derives[asked]
    options = dict(parsed(experiment.section(table), options, key))
    for at, (right, why) in asks.items():
        if (given := options.get(at, run.configuration.at(at))) not in (right, None):
            raise InputError(f"{key} is {asked}, and {at} {written(given)}; {why}.")
    if results is None:
        return run.configuration.at(path)
    files = [file for other in blocks if asked in blocks[other].derives for file in results[other]]
    other = Replicate(sweep.changed({}, shape), shape, 1.0, 0)
    return load(experiment.file).derive(asked, files, run, other, **options)
