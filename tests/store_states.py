"""The store under everything that happens to one: sweeps planned, made, stopped, extended, pruned, damaged.

Two sweeps share a store. Hypothesis chooses what happens and in which order; runs cost nothing. No finished run is made
again unless its file was damaged or nobody needed it, and what is combined, counted or said is right, or refused with its
name.
"""

import contextlib
import errno
import os
import re
import tempfile
from collections import Counter
from itertools import chain, zip_longest
from pathlib import Path
from unittest import mock

import numpy as np
import xarray as xr
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from pictures import text_of
from sweeps import DRAWN, OBSERVED, VALUES, Killed, contents, made, order, varied

from dem.base.errors import InputError
from dem.io.dataset import read
from dem.report.status import status
from dem.sweep.batch_job import make
from dem.sweep.combine import combine_block
from dem.sweep.config import parse
from dem.sweep.estimate import summary
from dem.sweep.prune import prune
from dem.sweep.state import SweepState
from dem.sweep.store import Store

FAILS = 6  # the run of this seed fails, while it does
NAMES = "a", "b"
ENDS = "none", "killed in a run", "killed before a file is there", "killed after it", "disk full"
DAMAGE = {
    "flipped": bytearray,
    "cut": lambda content: content[: len(content) // 2],
    "zeros": lambda content: bytes(len(content)),
    "another file": lambda content: b"x" + content,
    "gone": bytes,
}
WORK = {
    "end": st.sampled_from(ENDS),
    "when": st.integers(1, 12),
    "names": st.sampled_from([("a",), ("b",), NAMES]),
    "again": st.booleans(),
}
RUN = re.compile(r"[0-9a-f]{32}\.npz")


class Sweeps(RuleBasedStateMachine):
    """seeds of two sweeps; allowed: how often each run or bed may have been made again; packed: how often each bed
    was; damaged: contents that a file of the store got."""

    def __init__(self):
        super().__init__()
        self.place = contextlib.ExitStack()
        self.folder = Path(self.place.enter_context(tempfile.TemporaryDirectory())).resolve()
        self.place.enter_context(contextlib.chdir(self.folder))
        Path("drawn.py").write_text(DRAWN + OBSERVED)
        self.values = parse(VALUES | {"beside": str(self.folder)}).dump()
        self.seeds = {"a": (1, 2, FAILS), "b": (1, 3)}
        self.allowed, self.packed, self.left = Counter(), Counter(), {}
        self.damaged: dict[Path, list[bytes]] = {}
        self.store, self.failing = Store(), True
        self.really = Path.replace
        patch = mock.patch.object(Path, "replace", lambda part, target: self.replace(part, target))
        self.place.enter_context(patch)
        for name in NAMES:
            self.state(name).begin("drag")

    def teardown(self):
        """In the end both are made, and then what failed, and nothing happens."""
        with self.place:
            for again in (False, True):
                self.make("none", 1, NAMES, again)
            self.nothing_is_made_again_without_a_reason()

    def fails(self):
        return {f"{density} {FAILS}": "RunError" for density in (100, 300) if self.failing}

    # A process or a disk that ends in the middle of its work

    def count(self, what):
        """Whether the end that was chosen comes now."""
        if what in self.left:
            self.left[what] -= 1
        return self.left.get(what) == 0

    def replace(self, part, target):
        """Path.replace: how each file of the store comes into its place."""
        target = Path(target)
        full = self.count("disk full")
        if full or self.count("killed before a file is there"):
            if RUN.fullmatch(target.name):  # of this run or bed nothing is left
                self.allowed[target.stem] += 1
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) if full else Killed
        self.really(part, target)
        self.packed[target.stem] += target.match("beds/*/*")
        if self.count("killed after it"):
            raise Killed
        return target

    # What happens

    def state(self, name):
        values = {
            "sweep": varied("a", "c", seed=list(self.seeds[name])),
            "results": f"results/{name}",
            "batch": 3,
            "failures": 0.99,
        }
        return SweepState(parse(self.values | values))

    @rule(
        name=st.sampled_from(NAMES),
        seeds=st.sets(st.sampled_from(range(1, 7))),
        days=st.integers(-400, 400),
    )
    def plan(self, name, seeds, days):
        """A sweep has other seeds; what it had is made again only where it was pruned meanwhile. The clock has
        jumped, and with it the times of files."""
        for path in self.files():
            os.utime(path, (path.stat().st_mtime + 86400 * days,) * 2)
        self.seeds[name] = tuple(sorted({1} | seeds))
        self.state(name).begin("drag")

    @initialize(**WORK)
    def begin(self, **work):
        self.make(**work)

    @rule(**WORK)
    def make(self, end, when, names, again):
        """One sweep, or both at a time, planned first and made in turns. Runs that failed may be wanted again, and
        do not fail then."""
        at_work = [self.state(name) for name in names]
        self.failing, sound = not again, not self.spoiled()
        for work in at_work if sound else ():
            self.look(work)
            if again:
                self.retry(work)
        in_run = end == ENDS[1]
        order(fails=self.fails(), **({"left": when} if in_run else {}))
        self.left = {} if in_run else {end: when}
        try:
            missing = [
                [b.id for b in work.batches("drag") if not self.store.file_of(b.id).exists()]
                for work in at_work
            ]
            for work in at_work:
                work.begin("drag")
            for batch in filter(None, chain(*zip_longest(*missing))):
                make(self.store, batch)
            for work in at_work:
                combine_block(work, "drag", "drag", *work.combined("drag"))
        except (Killed, OSError) as error:
            assert self.left.get(end) == 0, error
        except KeyboardInterrupt:
            assert in_run
        except InputError as error:  # it names a damaged file, which the user then removes
            (path,) = [file for file in self.damaged if str(file) in str(error)]
            path.unlink(missing_ok=True)
        else:
            for work in at_work:
                failed = self.check(work, *work.combined("drag"))
                assert not (sound and again and failed)
        self.left = {}

    def look(self, work):
        """Status, dry run and a partial file say what the store holds, and change no file of it."""
        before, held = self.bytes(), self.held()
        runs = work.runs()
        failed = sum(held.get(run, False) for run in runs)
        there = sum(run in held for run in runs)
        left = len(runs) - there
        line, table = summary(work, 1).splitlines()[0], text_of(status(work))
        assert f"{len(runs)} runs (" in line and f"), {there - failed} finished" in line, line
        assert f"{left} to be made" in line and work.counts() == (there, len(runs)), line
        assert sum(map(int, re.findall(r"^(\d+) failed: ", table, re.M))) == failed, table
        waiting = re.findall(r"under way: 0, waiting: (\d+)\.", table)
        assert waiting == [str(left)] * bool(left), table
        if there > failed:
            combine_block(work, "drag", "drag", Path("part.nc"), partial=True)
            self.check(work, Path("part.nc"), held)
        assert before == self.bytes()

    def retry(self, work):
        """The failed runs of a sweep are forgotten, and nothing else is. Batches of another one may have them too."""
        held = self.held()
        failed = {run for run in work.runs() if held.get(run)}
        assert work.retry() == len(failed)
        assert {*self.held()} - failed == {*held} - failed

    def check(self, work, path, there=None):
        """A combined file has all runs of its sweep, each with what it gave; there: those of a partial file. Returns
        whether some failed."""
        dataset, force = xr.load_dataset(path), self.forces()
        for (case, seed), run in work.block("drag").runs.items():
            row = dataset.isel(case=case, seed=seed)
            missing = there is not None and run.id not in there
            assert row.seed == run.seed and row.run_id == ("" if missing else run.id)
            gap = missing or row.failure
            np.testing.assert_equal(float(row.drag[5]), np.nan if gap else force[run.id])
        return dataset.failure.any()

    @precondition(lambda self: self.files())
    @rule(which=st.integers(0, 99), at=st.integers(0, 2**20), how=st.sampled_from(sorted(DAMAGE)))
    def damage(self, which, at, how):
        """A disk loses or changes what a file of the store holds; its runs may then be made again."""
        files = self.files()
        path = files[which % len(files)]
        if path.suffix == ".damaged":
            return
        runs = [path.stem] if RUN.fullmatch(path.name) else []
        if path.suffix == ".nc":
            with contextlib.suppress(InputError):
                runs = read(path, ("run_id",))[0]["run_id"].tolist()
        self.allowed.update(runs)
        content = DAMAGE[how](bytearray(path.read_bytes()))
        if how == "flipped" and content:
            content[at % len(content)] ^= 1
        self.damaged.setdefault(path, []).append(content)
        path.unlink() if how == "gone" else path.write_bytes(content)

    @rule()
    def prune(self):
        """What no sweep needs goes, and nothing else."""
        runs = [run for name in NAMES for run in self.state(name).block("drag").unique()]
        needed = {name for run in runs for name in (run.id, run.bed_id)}
        before = self.files()
        prune(self.store)
        self.allowed.update((self.forces().keys() | self.packed.keys()) - needed)
        left = {path.name.partition(".")[0] for path in self.files()}
        held = {path.name.partition(".")[0] for path in before if path.suffix != ".damaged"}
        assert held & needed <= left  # checkpoints and beds too
        assert not {name for name in left if len(name) == 32} - needed

    # What holds at any time

    def files(self):
        return list(self.store.files())

    def bytes(self):
        return {path: path.read_bytes() for path in self.files()}

    def forces(self):
        """What each run gave, by its identity."""
        return {run: float(force) for run, force, *_ in map(str.split, made())}

    def spoiled(self):
        """Whether a file is there as it was damaged."""
        files = self.bytes()
        return any(files.get(path) in some for path, some in self.damaged.items())

    def held(self):
        """The runs that the store holds, and whether each failed."""
        runs = {}
        for path in sorted(self.files(), key=lambda path: path.suffix):  # batches first
            if path.suffix == ".nc":
                values = contents(path)
                for run, failure in zip(values["run_id"], values["failure"], strict=True):
                    runs[str(run)] = bool(failure) and runs.get(str(run), True)
            elif RUN.fullmatch(path.name) and path.parts[2] == "runs":
                with np.load(path) as file:
                    runs.setdefault(path.stem, bool(file["failure"]))
        return runs

    @invariant()
    def nothing_is_made_again_without_a_reason(self):
        """No bed, and no run but one that failed, which whoever asks next tries again."""
        counts = Counter(run for run, *_, seed in map(str.split, made()) if int(seed) != FAILS)
        for name, count in (counts | self.packed).items():
            assert count <= 1 + self.allowed[name]

    @invariant()
    def what_is_put_aside_was_damaged_and_keeps_its_bytes(self):
        for path, content in self.bytes().items():
            if path.suffix == ".damaged":
                assert content in self.damaged[path.with_suffix("")]
