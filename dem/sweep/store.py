"""The store that all sweeps share: batches of finished runs, and what those under way have so far.

batches/{batch}.nc      finished runs with all that they gave
batches/{batch}.json    what a batch is to make: its runs, and in the second line the values that they
                        share, once, and the values of each
runs/{xx}/{run}.npz     finished runs of batches that have not ended, and checkpoints
beds/{xx}/{bed}.npz     beds, for all runs that share them, and checkpoints of those that are packed
"""

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from filelock import Timeout

from dem.base.errors import InputError
from dem.base.files import arrays_of, bytes_of, lock, set_aside, write_arrays, write_bytes
from dem.base.plugins import refresh
from dem.base.provenance import compilers
from dem.base.source_hash import digest
from dem.experiment.config import of_values
from dem.experiment.replicate import Replicate
from dem.io.dataset import read

FOLDER = Path("results/store")


class Batch(NamedTuple):
    """Runs that one process makes into one file: its identity and theirs."""

    id: str
    runs: tuple[str, ...]


def batch_id(results: str, *runs: str) -> str:
    """Hash of run ids and folder of results, so that two sweeps at once write different files."""
    return digest(results, *runs)[:16]


class Store:
    """A folder of runs; values: of configurations that its plans do not have right."""

    def __init__(self, folder: Path = FOLDER, **values: str):
        self.folder, self.values = Path(folder), values
        self._runs: dict[str, tuple[str, ...]] = {}  # runs of batches, which never change

    def file_of(self, batch: str) -> Path:
        """The file of a batch."""
        return self.folder / "batches" / f"{batch}.nc"

    def plan_of(self, batch: str) -> Path:
        """The file that says what a batch is to make."""
        return self.folder / "batches" / f"{batch}.json"

    def run_of(self, run: str, end: str = ".npz") -> Path:
        """The file of a run that is in no batch yet."""
        return self.folder / "runs" / run[:2] / f"{run}{end}"

    # Batches

    def batches(self, end: str = "nc") -> Iterator[Batch]:
        """All batches that have a file with some end; one without runs is damaged."""
        for batch in sorted({path.stem for path in self.folder.glob(f"batches/*.{end}")}):
            yield Batch(batch, self._runs_in(batch))

    def _runs_in(self, batch: str) -> tuple[str, ...]:
        """The runs of a batch, as its plan says, or else its file."""
        if batch not in self._runs:
            try:
                with self.plan_of(batch).open(encoding="utf-8") as file:
                    runs = json.loads(file.readline())
            except (OSError, ValueError):
                try:
                    runs = read(self.file_of(batch), ("run_id",))[0]["run_id"].tolist()
                except InputError:
                    return ()
            self._runs[batch] = tuple(runs)
        return self._runs[batch]

    def rows_of(self, batch: str, *names: str) -> dict[str, dict]:
        """What the runs of a batch gave, by their identity: some variables, why each failed, and the
        time spent; raises InputError where its file is not there or damaged."""
        about = "run_id", "failure", "failure_reason", "spent"
        values, _ = read(self.file_of(batch), (*about, *names))
        runs = values.pop("run_id").tolist()
        return {
            run: {name: array[row] for name, array in values.items()}
            for row, run in enumerate(runs)
        }

    def rows(self, runs: Iterable[str], *names: str, kept: bool = False) -> dict[str, dict]:
        """Rows of these runs from all batches; a successful run is preferred to a failed one. kept:
        also rows of runs whose batch has not ended."""
        wanted, rows = set(runs), {}
        for batch in self.batches():
            if not wanted.isdisjoint(batch.runs):
                for run, row in self.rows_of(batch.id, *names).items():
                    if run in wanted and (run not in rows or rows[run]["failure"]):
                        rows[run] = row
        left = wanted - rows.keys() if kept else ()
        return rows | {run: row for run in left if (row := self.kept(run))}

    def replicates(self, batch: str, again: bool = True) -> list[Replicate]:
        """What the runs of a batch are; raises InputError where its plan is not of today's code.

        again: whether files of a user are then read once more, because a worker lives on.
        """
        path = self.plan_of(batch)
        with suppress(FileNotFoundError):
            content = bytes_of(path)
        # what is wrong with a plan does not matter, because it is written again
        with suppress(Exception):
            head, body = content.decode().splitlines()
            shared, others = json.loads(body)
            replicates = [of_values(shared | values | self.values) for values in others]
            if json.loads(head) == [run.id for run in replicates]:
                return replicates
        if again:
            refresh()
            return self.replicates(batch, again=False)
        raise InputError(
            f"{path}: it is no plan of a batch for this version of the code with {compilers()}; "
            "start the sweep, and workers that live on, again."
        )

    def write_plan(self, batch: Batch, replicates: list[Replicate]) -> None:
        """Write what a batch is to make."""
        values = [replicate.values().items() for replicate in replicates]
        shared = [item for item in values[0] if all(item in other for other in values)]
        others = [dict(item for item in items if item not in shared) for items in values]
        text = f"{json.dumps(batch.runs)}\n{json.dumps([dict(shared), others])}\n"
        write_bytes(self.plan_of(batch.id), text.encode())

    def add(self, batch: str, content: bytes | None) -> None:
        """Add the file of a batch, if it was made elsewhere."""
        if content is not None:
            write_bytes(self.file_of(batch), content)

    # Beds and finished runs

    def file_of_bed(self, replicate: Replicate) -> Path:
        name = replicate.bed_id
        return self.folder / "beds" / name[:2] / f"{name}.npz"

    def bed(self, replicate: Replicate, make) -> dict:
        """The bed of a run by the names of Bed, but for its periods: the stored one, or as
        `make(checkpoint)` packs it, once for all processes. One that was stopped goes on."""
        path = self.file_of_bed(replicate)
        if (bed := load(path)) is None:
            with lock(path.with_name(".lock")):
                if (bed := load(path, aside=True)) is None:
                    checkpoint = path.with_suffix(".checkpoint.npz")
                    load(checkpoint, aside=True)
                    bed = make(checkpoint)._asdict()
                    del bed["periodic"]  # the configuration says it
                    write_arrays(path, bed)
                    checkpoint.unlink(missing_ok=True)
        return bed

    def keep(self, run: str, values: dict) -> None:
        """Keep what a run gave until its batch is whole."""
        write_arrays(self.run_of(run), values)

    def kept(self, run: str, aside: bool = False) -> dict | None:
        """What a run gave whose batch has not ended, None if it is not there or damaged, and then put
        aside by who makes it."""
        return load(self.run_of(run), aside)

    def locked_runs(self) -> set[str]:
        """Identities of the runs that some process is making."""
        return {path.stem for path in (self.folder / "runs").glob("*/*.lock") if _is_held(path)}

    def forget(self, runs: Iterable[str]) -> None:
        """Remove runs that a batch holds now."""
        for run in runs:
            for end in (".npz", ".checkpoint.npz", ".lock"):
                self.run_of(run, end).unlink(missing_ok=True)

    def files(self) -> Iterator[Path]:
        """All files that a store writes, but for locks; others are the user's."""
        batch, run = (count * "[0-9a-f]" for count in (16, 32))
        for names in (f"batches/{batch}.*", f"runs/*/{run}.*", f"beds/*/{run}.*"):
            for path in sorted(self.folder.glob(names)):
                if path.suffix in (".nc", ".json", ".npz", ".damaged"):
                    yield path


def load(path: Path, aside: bool = False) -> dict | None:
    """The arrays of a file; None where it is not there, or is damaged, and then put aside if asked."""
    try:
        arrays = arrays_of(path)
    except FileNotFoundError:
        return None
    if arrays is None and aside:
        set_aside(path)
    return arrays


def _is_held(path: Path) -> bool:
    """Whether a process holds a lock; the lock of another user may not be tried."""
    try:
        with lock(path, 0):
            return False
    except (Timeout, PermissionError):
        return True
