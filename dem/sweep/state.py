"""State of a sweep: the files its blocks need, which exist, and how the others are made."""

import json
import math
import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from functools import cached_property
from itertools import chain, takewhile
from pathlib import Path

import numpy as np

from dem.base.errors import InputError, RunError
from dem.base.files import write_bytes
from dem.base.yaml_file import read, text_of
from dem.experiment.replicate import Replicate
from dem.io.dataset import BY_CASE
from dem.io.lazily import open_lazily
from dem.packing.cost import near_jamming
from dem.sweep.batches import plan_batches
from dem.sweep.combine import combine_block, combined_runs
from dem.sweep.config import CONFIG, Sweep, load, parse
from dem.sweep.expand import Block, expand
from dem.sweep.precision import GridPoint, counts, run_mean, short_of
from dem.sweep.store import FOLDER, Batch, Store
from dem.sweep.workers import Workers, make_batches

FASTEST = 0.1  # of the velocity of sound, beyond which a bed is shocked rather than sheared
# nothing that is computed reads them
UNREAD = {"batch", "figures", "results", "studies", "beside", "threads"}


def slow_beds(runs: Iterable[Replicate]) -> list[str]:
    """What to ask for instead of large beds of discs near random close packing."""
    cases = {
        (run.shape.granules, run.configuration.packing.fraction)
        for run in runs
        if run.shape.kind == "disc" and run.configuration.packing.fraction
    }
    return [f"Warning: {words}." for case in sorted(cases) if (words := near_jamming(*case))]


class SweepState:
    """A sweep and the store that holds its runs. Nothing is written before `begin`.

    sweep: the configuration
    store: where runs are
    root:  folder that all paths of the sweep are in; the working folder if absent
    """

    def __init__(self, sweep: Sweep, store: Store | None = None, root: Path = Path()):
        self.sweep, self.root = sweep, Path(root)
        self.store = store or Store(self.root / FOLDER)
        self._rounds: dict[str, list[Block]] = {}  # of each block
        self._planned: dict[str, Batch] = {}  # those that hold the runs, by identity
        self._new: dict[Batch, list[Replicate]] = {}  # runs of batches whose plans are not written
        self._means: dict[str, dict[str, tuple[float, str]]] = {}  # by variable and run

    @classmethod
    def of(cls, path: Path, root: Path = Path()) -> "SweepState":
        """The sweep of a file; a resolved configuration says its root itself."""
        sweep = load(path)
        resolved = f"{sweep.results}/{CONFIG}"
        if str(path).endswith(f"/{resolved}"):
            root = Path(str(path).removesuffix(resolved))
        return cls(sweep, root=root)

    @classmethod
    def of_values(cls, values: dict, files: list, root: str = "") -> "SweepState":
        """The sweep of the values that Snakemake has read of some files, and perhaps changed."""
        names = list(map(os.path.relpath, files))
        for name in names:
            read(name)  # which refuses what Snakemake reads as another value
        return cls(parse(values, ", ".join(names) or "the configuration"), root=root)

    # Names of files

    @property
    def results(self) -> Path:
        """Folder of results."""
        return self.root / self.sweep.results

    @cached_property
    def folders(self) -> dict[str, str]:
        """Block by the folder of its combined files, below the root."""
        return {self.folder_of(name): name for name in self.sweep.blocks}

    def folder_of(self, name: str) -> str:
        """Folder of the combined files of a block, below the root."""
        alone = list(self.sweep.blocks) == ["drag"]
        return self.sweep.results if alone else f"{self.sweep.results}/{name}"

    def observables(self, name: str) -> tuple[str, ...]:
        """What the runs of a block record, each a combined file. Snapshots stay in the batches,
        unless figures of beds by case can be drawn from them."""
        block = self.block(name)
        recorded = block.first.configuration.recorded
        return tuple(o for o in recorded if o != "snapshots" or {*block.dims} in BY_CASE)

    def combined(self, name: str | None = None) -> list[Path]:
        """The combined files of a block, the first if absent; the runs of the first one are compared."""
        name = name or next(iter(self.sweep.blocks))
        folder = self.root / self.folder_of(name)
        return [folder / f"{observable}.nc" for observable in self.observables(name)]

    def needed(self, name: str) -> list[Path]:
        """Combined files of other blocks that the values of a block are derived from."""
        return [path for other in self.sweep.needed(name) for path in self.combined(other)]

    def is_known(self, name: str) -> bool:
        """Whether all values of a block are known, because what they are derived from exists."""
        return all(path.is_file() for path in self.needed(name))

    # Runs, and replicates that are added until a mean is known well enough

    def block(self, name: str, rounds: int | None = None) -> Block:
        """All runs of a block; what is derived is as the file has it until it can be known.

        rounds: of replicates after the first; if absent, all that the existing runs suffice for.
        """
        if name not in self._rounds:
            block = self.sweep.block(name)
            if not self.is_known(name):
                return block
            if needed := self.sweep.needed(name):
                with ExitStack() as stack:
                    results = {
                        other: [stack.enter_context(open_lazily(f)) for f in self.combined(other)]
                        for other in needed
                    }
                    block = expand(self.sweep, name, results)
            self._rounds[name] = [block]
            while self.grow(name):
                pass
        blocks = self._rounds[name]
        return blocks[-1 if rounds is None else min(rounds, len(blocks) - 1)]

    def grow(self, name: str) -> bool:
        """Add a round to a block, where all its runs exist and it takes one."""
        block = self._rounds[name][-1]
        if block.until is None:
            return False
        values = self.values(block)
        if any(len(values[point]) < count for point, count in block.counts.items()):
            return False
        all_values = np.concatenate(list(values.values()))
        if np.isnan(all_values).sum() > self.sweep.failures * all_values.size:
            return False  # more runs failed than may; combining says so
        grown = counts(block.until, values, block.partners)
        if grown == block.counts:
            return False
        self._rounds[name].append(expand(self.sweep, name, counts=grown))
        return True

    def rounds(self, name: str) -> Iterator[int]:
        """The rounds of a block, one after another; each must be made before the next."""
        if self.block(name).until:
            for number, block in enumerate(self._rounds[name]):  # which grow meanwhile
                yield number
                if block is self._rounds[name][-1]:
                    self.grow(name)

    def values(self, block: Block) -> dict[GridPoint, np.ndarray]:
        """What is wanted of the existing runs of a block, by point: one value a run, in the order
        of the seeds, up to the first that does not exist."""
        known = self.means(block, block.until.variable)
        return {
            point: np.array(
                [known[run.id][0] for run in takewhile(lambda run: run.id in known, runs)]
            )
            for point, runs in block.replicates.items()
        }

    def means(
        self, block: Block, variable: str, kept: bool = False
    ) -> dict[str, tuple[float, str]]:
        """The mean of a variable over each run that exists, by identity, and why a run failed: of
        all of a block, and perhaps of others. Files of runs never change, so each is read once.

        kept: also of batches that have not ended. Decisions wait for these, so that they are the
        same after any stop.
        """
        runs = {run.id: run for run in block.unique()}
        means = self._means.setdefault(variable, {})
        rows = self.store.rows(runs.keys() - means.keys(), variable, kept=kept)
        new = {run: run_mean(runs[run], variable, row) for run, row in rows.items()}
        if not kept:
            means |= new
        return means | new

    def replicates(self) -> Iterator[Replicate]:
        """All runs, as far as they are known."""
        return chain.from_iterable(self.block(name).unique() for name in self.sweep.blocks)

    def runs(self) -> set[str]:
        """Their identities."""
        return {run for name in self.sweep.blocks for run in self.block(name).points}

    # Batches

    def batches(self, name: str, rounds: int | None = None) -> list[Batch]:
        """The batches that hold the runs of a block; in one process always the same.

        rounds: as of `block`.
        """
        for path in self.needed(name):
            if not path.is_file():
                raise InputError(f"{path}: it is missing; the block {name} needs it first.")
        for other in self.sweep.blocks:  # in one order, because blocks share runs
            if other == name or self.is_known(other):
                planned = {run for batch in self._planned.values() for run in batch.runs}
                if left := [run for run in self.block(other).unique() if run.id not in planned]:
                    batches, new = plan_batches(
                        self.store.batches(), left, self.sweep.batch, self.sweep.results
                    )
                    self._planned |= {batch.id: batch for batch in batches}
                    self._new |= new
        runs = self.block(name, rounds).points.keys()
        return [batch for batch in self._planned.values() if not runs.isdisjoint(batch.runs)]

    def files(self, name: str) -> list[Path]:
        """The files of the batches of a block."""
        return [self.store.file_of(batch.id) for batch in self.batches(name)]

    def begin(self, *names: str) -> str:
        """Write what jobs read: the resolved configuration, whose path is returned, and what the
        batches of some blocks are to make."""
        path = self.results / CONFIG
        write_bytes(
            path, text_of(self.sweep.dump()).encode()
        )  # first, so that pruning knows what is needed
        for name in names:
            self.batches(name)
        for batch, runs in self._new.items():
            self.store.write_plan(batch, runs)
        self._new.clear()
        return str(path)

    def counts(self) -> tuple[int, int]:
        """How many runs exist, also of batches that have not ended, and how many the sweep has."""
        wanted = self.runs()
        left = wanted.difference(*(batch.runs for batch in self.store.batches()))
        return len(wanted) - sum(not self.store.run_of(run).is_file() for run in left), len(wanted)

    # All of it

    def check(self) -> list[str]:
        """Warnings: of a new store, of a solid that is too fast, of a bed that nothing but
        friction holds, of large beds near jamming, and of runs that will be gone from combined files."""
        warnings = [*self._fast_solid(), *self._loose_bed(), *slow_beds(self.replicates())]
        if not self.store.folder.is_dir():
            warnings.append(
                f"{self.store.folder.absolute()}: this store of runs is new, and has none yet; "
                "sweeps that are started in this folder share it."
            )
        for name in self.sweep.blocks:
            if self.sweep.needed(name):
                continue  # values that follow from results may not be known
            path = self.combined(name)[0]
            held = combined_runs(path)
            if lost := held - self.block(name).points.keys():
                warnings.append(
                    f"{path}: {len(lost)} of the {len(held)} runs that it held are no longer in "
                    "this sweep, because its values or the code changed; the store keeps them "
                    "until dem store --prune."
                )
        return warnings

    def _fast_solid(self) -> Iterator[str]:
        """A warning of the fastest solid, where another unit was probably meant: mm/s for m/s, MPa
        for Pa."""
        speeds = [(0.0, "", 0.0, 0.0)]  # over the speed of sound; key, speed, speed of sound
        for run in {id(run.configuration): run for run in self.replicates()}.values():
            c = run.configuration
            sound = math.sqrt(c.material.young_modulus / run.density)
            moving = {f"solids.{name}": solid for name, solid in c.solids.items()}
            if c.experiment == "drag":
                moving["cylinder"] = c.cylinder
            for phase, section in c.phases.items():
                moving |= {f"phases.{phase}.motion.{k}": v for k, v in section.motion.items()}
            for key, section in moving.items():
                speed = abs(section.velocity or 0.0)
                speeds.append((speed / sound, f"{key}.velocity", speed, sound))
        mach, key, speed, sound = max(speeds)
        if mach > FASTEST:
            yield (
                f"Warning: {key} is {speed:g} m/s, {mach:.2g} of the velocity of "
                f"sound in a granule, sqrt(material.young_modulus / density) = {sound:.4g} m/s; it "
                f"should be below {FASTEST:g}. Are all values in SI units?"
            )

    def _loose_bed(self) -> Iterator[str]:
        """A warning of a bed that moves along with the cylinder: no wall is across its way."""
        ways = {
            axis
            for run in self.replicates()
            if (c := run.configuration).experiment == "drag"
            if not (c.base_plate and c.base_plate.friction)
            for axis, share in zip("xy", c.cylinder.ahead, strict=True)
            if axis in c.periodic and abs(share) > 1e-3  # more than rounding
        }
        for axis in sorted(ways):
            yield (
                f"Warning: the cylinder is drawn along {axis}, and periodic has it too: nothing but "
                "friction with walls holds the bed. It will move along, and the drag is at most that "
                "friction."
            )

    def retry(self) -> int:
        """Let the failed runs be made again; returns how many there are."""
        from dem.sweep.batch_job import retry  # with the kernels

        known = [name for name in self.sweep.blocks if self.is_known(name)]
        self.begin(*known)
        batches = dict.fromkeys(batch.id for name in known for batch in self.batches(name))
        return sum(retry(self.store, batch, self.store.replicates(batch)) for batch in batches)

    def make(self, workers: Workers, progress=lambda done, failed: None) -> None:
        """Make all that does not exist yet, on some workers; raises RunError.

        progress is called with how many runs exist, and how many of the new ones failed.
        """
        for name in self.sweep.blocks:  # a block comes after those that it needs
            while True:
                self.begin(name)
                new = [b for b in self.batches(name) if not self.store.file_of(b.id).is_file()]
                kept = sum(self.store.run_of(run).is_file() for batch in new for run in batch.runs)
                before = self.counts()[0] - kept
                make_batches(
                    self.store, new, workers, lambda n, failed, n0=before: progress(n0 + n, failed)
                )
                if not self.grow(name):
                    break
            for path in self.combined(name):
                combine_block(self, name, path.stem, path)
        if words := self.near_zero(*self.sweep.blocks):
            raise RunError(words)

    def near_zero(self, *names: str) -> str:
        """A sentence on blocks that ask for a share of means that may be zero; "" if none does."""
        blocks = [block for name in names if (block := self.block(name)).until]
        words = (short_of(block, self.values(block), near_zero=True) for block in blocks)
        return " ".join(filter(None, words))

    def text(self, name: str | None = None, *without: str) -> str:
        """What is computed of the runs of a block, or of none, reads in the configuration, as
        text."""
        kept = self.sweep.dump()
        if name is not None:
            kept["sweep"] = self.sweep.blocks[name]
        return json.dumps({k: v for k, v in kept.items() if k not in UNREAD.union(without)})
