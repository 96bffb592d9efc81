"""The files of a study: one a job, and one with all of them."""

from pathlib import Path
from typing import NamedTuple

import xarray as xr

from dem.base import provenance
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.experiment.config import Sweep
from dem.io.checksums import seal
from dem.io.dataset import content_of, global_attributes, write
from dem.sweep.combine import open_lazily, require

SAME = ("default_fraction", "window_start", "window_stop")  # attributes that all parts must share
ORIGIN = ("versions", "git_revision", "source_hash")


class Study(NamedTuple):
    """What a study is about, the command that makes its parts, its layout as in dem.io.dataset, and
    the dimensions along which jobs are put one after another."""

    about: str
    command: str
    variables: dict
    concatenated: tuple[str, ...]
    makers: tuple[str, ...]  # modules that make its parts

    def write_part(self, path: Path, sweep: Sweep, values: dict) -> None:
        """Write the variables that one job has made."""
        low, high = sweep.record.window
        attrs = global_attributes(
            f"{sweep.title}: {self.about}",
            self.command,
            versions=provenance.versions(),
            git_revision=provenance.git_revision(),
            source_hash=sweep.code_of(*self.makers, shapes=sweep.shapes),
            default_fraction=sweep.numerics.step_fraction,
            window_start=low,
            window_stop=high,
        )
        write(path, values, attrs, self.variables)

    def read_part(self, path: Path) -> xr.Dataset:
        """What one job has made; raises InputError for another file."""
        with open_lazily(path) as dataset:
            if not set(dataset.variables) <= set(self.variables):
                raise InputError(f"{path}: it is no part of the study: {self.about}.")
            require(dataset, path, self.variables, (), (*SAME, *ORIGIN, "title", "history"))
            return dataset.load()

    def join(self, paths: list[Path]) -> xr.Dataset:
        """All parts in one; what many jobs share out is put one after another."""
        parts = [self.read_part(path) for path in paths]
        with content_of(Path(paths[0]).parent):
            return self._joined(parts)

    def _joined(self, parts: list[xr.Dataset]) -> xr.Dataset:
        joined = [part.drop_dims(self.concatenated, errors="ignore") for part in parts]
        for dim in self.concatenated:
            some = [_along(part, dim) for part in parts if dim in part.dims]
            if some:
                joined.append(xr.concat(
                    some, dim, data_vars="minimal", coords="minimal", compat="override",
                    join="override",
                ))  # fmt: skip
        shared = [part for part in parts if set(self.concatenated) & set(part.dims)] or parts
        for name in SAME:  # of the jobs that share out one thing; others do not depend on these
            values = {float(part.attrs[name]) for part in shared}
            if len(values) > 1:
                raise InputError(
                    f"{name} differs between the files: {sorted(values)}; make them again."
                )
        whole = xr.merge(joined, compat="no_conflicts", combine_attrs="drop_conflicts")
        whole.attrs |= {name: shared[0].attrs[name] for name in SAME}
        for name in ORIGIN:
            whole.attrs[name] = "; ".join(dict.fromkeys(part.attrs[name] for part in parts))
        return whole.assign_attrs(history=parts[-1].attrs["history"] + ", combined")

    def write_joined(self, path: Path, dataset: xr.Dataset) -> None:
        """Write the file of the whole study, atomically."""
        numbers = [
            name for name, v in dataset.variables.items() if v.dtype.kind in "fiu" and v.dims
        ]
        encoding = {name: {"zlib": True, "shuffle": True, "fletcher32": True} for name in numbers}
        encoding |= {  # texts are characters, as in the parts, but of the longest of all
            name: {"dtype": "S1", "char_dim_name": f"{name}_length"}
            for name, v in dataset.variables.items() if v.dtype.kind not in "fiu"
        }  # fmt: skip
        for name in set(dataset.dims) & set(numbers):  # an axis has no gaps
            encoding[name]["_FillValue"] = None
        with atomic(path) as part:
            dataset.drop_encoding().to_netcdf(part, engine="netcdf4", encoding=encoding)
            seal(part)


def _along(part: xr.Dataset, dim: str) -> xr.Dataset:
    """The variables of a part that have a dimension."""
    return part[[name for name in part.data_vars if dim in part[name].dims]]
