"""The store under everything that happens to one: sweeps planned, made, stopped, extended, pruned, damaged.

Two sweeps share a store. Hypothesis chooses what happens and in which order; runs cost nothing here. No finished
run is made again unless its file was damaged or nobody needed it, no file of a user's is touched, and what is
read is right, or refused with its name.
"""

import contextlib
import errno
import os
import tempfile
from collections import Counter
from pathlib import Path
from unittest import mock

import numpy as np
import xarray as xr
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule
from sweeps import Killed, smoke

from dem.base.errors import InputError, RunError
from dem.io.dataset import read
from dem.packing.random import Bed
from dem.sweep import batch as making
from dem.sweep.combine import combine_block
from dem.sweep.prune import prune
from dem.sweep.state import SweepState
from dem.sweep.store import Store

SEEDS = range(1, 7)
FAILS = 6  # the run of this seed fails
NAMES = "a", "b"
NO_SPACE = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
ENDS = "none", "killed in a run", "killed before a file is there", "killed after it", "disk full"


def value_of(run):
    """What a run gives, everywhere."""
    return float(int(run[:6], 16))


def empty_bed(replicate, checkpoint):
    return Bed(np.zeros((2, 2)), np.zeros(2), *np.ones(len(Bed._fields) - 3), (None, None))


class Sweeps(RuleBasedStateMachine):
    """seeds of two sweeps; run_counts: how often each run was made; allowed: how often it may have been
    made again; user_files: texts of the user's own files."""

    def __init__(self):
        super().__init__()
        self.place = contextlib.ExitStack()
        self.folder = Path(self.place.enter_context(tempfile.TemporaryDirectory())).resolve()
        self.place.enter_context(contextlib.chdir(self.folder))
        self.seeds = dict.fromkeys(NAMES, ())
        self.run_counts, self.allowed, self.left, self.user_files = Counter(), Counter(), {}, {}
        self.store, self.damaged = Store(), set()
        patches = (
            mock.patch.object(making, "_run", self.run),
            mock.patch.object(making, "make_bed", empty_bed),
            mock.patch.object(Path, "replace", lambda part, target: self.replace(part, target)),
        )
        self.really = Path.replace
        for patch in patches:
            self.place.enter_context(patch)

    def teardown(self):
        self.place.close()

    # What stands for a simulation, and for a process or a disk that ends in the middle of its work

    def count(self, what):
        """Whether the end that was chosen comes now."""
        if what in self.left:
            self.left[what] -= 1
        return self.left.get(what) == 0

    def run(self, store, replicate, progress):
        store.run_of(replicate.id, ".checkpoint.npz").write_bytes(b"half of a run")
        if self.count("killed in a run"):
            raise Killed
        store.bed(replicate, making.make_bed)
        if replicate.seed == FAILS:
            raise RunError("this run fails")  # whoever asks next tries again
        self.run_counts[replicate.id] += 1
        configuration = replicate.configuration
        sizes = configuration.module.sizes(replicate)
        return {
            name: np.full([sizes[dim] for dim in dims], value_of(replicate.id))
            for name, (dims, *_) in configuration.module.layout.items()
        }

    def replace(self, part, target):
        """Path.replace: how each file of the store comes into its place."""
        target = Path(target)
        full = self.count("disk full")
        if full or self.count("killed before a file is there"):
            if target.parent.parent.name == "runs":  # of this run nothing is left
                self.allowed[target.stem] += 1
            raise NO_SPACE if full else Killed
        self.really(part, target)
        if self.count("killed after it"):
            raise Killed
        return target

    # What happens

    def state(self, name):
        values = {"case": ["c1", "c12"], "seed": list(self.seeds[name])}
        return SweepState(smoke(sweep=values, results=f"results/{name}", batch=3, failures=0.99))

    @rule(name=st.sampled_from(NAMES), seeds=st.sets(st.sampled_from(SEEDS)))
    def plan(self, name, seeds):
        """A sweep has other seeds; what it had is made again only where it was pruned meanwhile."""
        self.seeds[name] = tuple(sorted({1} | seeds))
        self.state(name).begin("drag")

    @precondition(lambda self: any(self.seeds.values()))
    @rule(
        end=st.sampled_from(ENDS),
        when=st.integers(1, 30),
        both=st.booleans(),
        name=st.sampled_from(NAMES),
    )
    def make(self, end, when, both, name):
        """One sweep, or both at a time, planned first and made in turns."""
        names = [sweep for sweep in (NAMES if both else (name,)) if self.seeds[sweep]]
        self.left = {end: when}
        try:
            at_work = [self.state(sweep) for sweep in names]
            jobs = [
                [
                    (work, b.id)
                    for b in work.batches("drag")
                    if not work.store.file_of(b.id).exists()
                ]
                for work in at_work
            ]
            for work in at_work:
                work.begin("drag")
            for turn in zip(*jobs, strict=False):
                for work, batch in turn:
                    making.make(work.store, batch)
            for job in jobs:
                for work, batch in job:
                    making.make(work.store, batch)
            for sweep, work in zip(names, at_work, strict=True):
                combine_block(work, "drag", "drag", Path(f"results/{sweep}/drag.nc"))
        except (Killed, OSError) as error:
            assert self.left.get(end) == 0, error
            part = self.folder / f"results/store/runs/ab/.x.npz.{os.uname().nodename}.1.dem.part"
            part.parent.mkdir(parents=True, exist_ok=True)
            part.write_bytes(b"half")
        except InputError as error:  # it names a damaged file, which the user then removes
            (path,) = [file for file in self.damaged if str(file) in str(error)]
            path.unlink()
        else:
            for sweep in names:
                self.check(Path(f"results/{sweep}/drag.nc"), self.seeds[sweep])
        self.left = {}

    def check(self, path, seeds):
        """A combined file has all runs of its sweep, each with what it gave."""
        with xr.open_dataset(path) as dataset:
            dataset.load()
        assert tuple(dataset.seed.values) == seeds
        for seed in seeds:
            for case in dataset.case.values:
                run = dataset.sel(case=case, seed=seed)
                expected = np.nan if seed == FAILS else value_of(str(run.run_id.values))
                np.testing.assert_array_equal(run.max_overlap, expected)

    @precondition(lambda self: self.files())
    @rule(data=st.data(), how=st.sampled_from(["flipped", "cut", "empty", "gone"]))
    def damage(self, data, how):
        """A disk loses or changes what a file of the store holds; its runs may then be made again."""
        path = data.draw(st.sampled_from(self.files()))
        runs = [path.stem] if path.parent.parent.name == "runs" else []
        if path.suffix == ".nc":
            with contextlib.suppress(InputError):
                runs = read(path, ("run_id",))[0]["run_id"].tolist()
        self.allowed.update(runs)
        self.damaged.add(path)
        content = bytearray(path.read_bytes())
        if how == "gone":
            path.unlink()
            return
        if how == "flipped" and content:
            content[data.draw(st.integers(0, len(content) - 1))] ^= 1
        path.write_bytes({"flipped": content, "cut": content[: len(content) // 2]}.get(how, b""))

    @rule()
    def prune(self):
        """What no sweep needs goes, and nothing else; where that cannot be known, nothing goes."""
        runs = [
            run
            for name in NAMES
            if self.seeds[name]
            for run in self.state(name).block("drag").unique()
        ]
        needed, beds = {run.id for run in runs}, {run.bed_id for run in runs}
        files = self.files()
        try:
            prune(self.store)
        except InputError:
            assert self.files() == files
        else:
            self.allowed.update(self.run_counts.keys() - needed)
            gone = set(files) - set(self.files())
            removed = {path.name.partition(".")[0] for path in gone if path.suffix != ".damaged"}
            assert not removed & (needed | beds)  # checkpoints and beds too

    @rule(
        name=st.sampled_from(["store/batches/notes.txt", "store/beds/ab/mine.npz", "a/notes.txt"])
    )
    def user_file(self, name):
        """The user puts a file of his own somewhere."""
        path = Path("results") / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
        self.user_files[path] = name

    @rule(days=st.integers(-400, 400))
    def clock(self, days):
        """The clock jumps, and with it the times of files."""
        for path in self.files():
            os.utime(path, (path.stat().st_mtime + 86400 * days,) * 2)

    # What holds at any time

    def files(self):
        return list(self.store.files())

    @invariant()
    def no_run_is_made_again_without_a_reason(self):
        for run, count in self.run_counts.items():
            assert count <= 1 + self.allowed[run]

    @invariant()
    def files_of_the_user_are_as_they_were(self):
        for path, content in self.user_files.items():
            assert path.read_text() == content

    @invariant()
    def what_is_read_is_right_or_refused_by_name(self):
        for path in (self.folder / "results/store/batches").glob("*.nc"):
            try:
                values, _ = read(path, ("run_id", "failure", "max_overlap"))
            except InputError as error:
                assert path.name in str(error)
            else:
                for run, failure, overlap in zip(*values.values(), strict=True):
                    assert failure or (overlap == value_of(run)).all()


TestSweeps = Sweeps.TestCase
TestSweeps.settings = settings(
    settings.get_profile("night"), max_examples=1000, stateful_step_count=20
)
