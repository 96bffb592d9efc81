"""Snakemake in processes that begin with its libraries, because importing them takes most of a dry run.

The package itself is imported in each process, because tests edit it.
"""

import multiprocessing
import os
import re
import runpy
import subprocess
import sys
import tempfile
from contextlib import ExitStack, contextmanager
from pathlib import Path

from project import ROOT

LIBRARIES = [
    "snakemake.cli",
    "snakemake.report.html_reporter",
    "numba",
    "pydantic",
    "scipy.stats",
    "xarray",
]
SMOKE = "config/smoke.yaml"


def environment(folder) -> dict[str, str]:
    """For commands that use the sources of a folder."""
    bin_folder = Path(sys.executable).parent
    return os.environ | {"PYTHONPATH": str(folder), "PATH": f"{bin_folder}:{os.environ['PATH']}"}


def snakemake(folder, *arguments, configfile=SMOKE, sources=None) -> subprocess.CompletedProcess:
    """Run snakemake in a folder, as `python -m snakemake` does; sources: their folder, if another."""
    words = [*arguments, *(["--configfile", configfile] if configfile else [])]
    sources = sources or folder
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(LIBRARIES)
    with tempfile.TemporaryDirectory() as temporary:
        files = [Path(temporary) / name for name in ("stdout", "stderr")]
        process = context.Process(
            target=_run, args=(words, folder, sources, environment(sources), files)
        )
        process.start()
        process.join()
        return subprocess.CompletedProcess(words, process.exitcode, *(p.read_text() for p in files))


def _run(words, folder, sources, environment, files):
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    for number, path in enumerate(files, start=1):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND), number)
    assert "dem" not in sys.modules
    sys.path.insert(0, str(sources))
    sys.argv = ["snakemake", *words]
    runpy.run_module("snakemake", run_name="__main__", alter_sys=True)


@contextmanager
def edited(folder, changes):
    """Files that are changed for a while: (name, what is added, or what is put for what is there)."""
    with ExitStack() as stack:
        for name, change in changes:
            path = folder / name
            text, stamp = (path.read_text(), path.stat()) if path.exists() else ("", None)
            new = text.replace(*change) if isinstance(change, tuple) else text + change
            assert new != text, f"{name} has no {change[0]}"
            path.write_text(new)
            if stamp is None:
                stack.callback(path.unlink)
            else:  # in the order of time: the first callback is the last one called
                stack.callback(os.utime, path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))
                stack.callback(path.write_text, text)
        yield


def completed(folder, *arguments, **options) -> str:
    """What Snakemake says, which ends well."""
    run = snakemake(folder, *arguments, **options)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout + run.stderr


def planned(folder, *arguments, **options):
    """Number of jobs of each rule that a dry run announces."""
    text = completed(folder, *arguments, "-n", **options)
    table = re.search(r"\njob +count\n-+ +-+\n(.*?)\ntotal", text, re.S)
    return {} if table is None else {k: int(n) for k, n in re.findall(r"(\w+) +(\d+)", table[1])}


def run(*words, cwd, path=()):
    """A command of Python; what it says."""
    process = subprocess.run(
        [sys.executable, *map(str, words)],
        cwd=cwd,
        env=environment(os.pathsep.join(map(str, (*path, ROOT)))),
        text=True,
        capture_output=True,
        timeout=600,
    )
    assert process.returncode == 0, process.stderr + process.stdout
    return process.stdout + process.stderr
