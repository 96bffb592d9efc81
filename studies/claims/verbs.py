"""`python -m studies claims test`."""

from pathlib import Path

from dem.base.errors import InputError
from dem.cli.options import argument, option
from dem.io.progress import bar


def test(
    data: argument(Path, "claims.nc, or drag.nc of any sweep."),
    name: option(str | None, "Show one claim in full.", "--claim") = None,
    margin: option(float, "Relative difference that counts as significant, 0 to 1.") = 0.18,
):
    """Print which claims these runs support, contradict or leave undecided.

    Example: python -m studies claims test results/drag.nc
    """
    if not 0.0 <= margin <= 1.0:
        raise InputError(f"margin is {margin}; it must be between 0 and 1.")
    from dem.cli.show import PlainConsole

    with bar(f"testing claims on {data}"):
        from dem.io.dataset import content_of
        from studies.claims.findings import detail, table_of
        from studies.claims.verdicts import judge

        with content_of(data):
            verdicts = {verdict.claim.name: verdict for verdict in judge(_read(data, margin))}
    if name is None:
        summary = table_of(verdicts.values())
    elif name in verdicts:
        summary = detail(verdicts[name])
    else:
        raise InputError(f"claim is {name!r}; there are {', '.join(verdicts)}.")
    PlainConsole(width=160).print(summary)


def _read(path: Path, margin: float):
    """Runs in claims.nc, or in drag.nc with the flow.nc beside it; raises InputError."""
    from dem.io.lazily import open_lazily, require, require_drag
    from studies.claims import IRREGULARITY
    from studies.claims.evidence import from_study, from_sweep
    from studies.claims.results import VARIABLES

    window = "window_start", "window_stop"
    with open_lazily(path) as dataset:
        if "run_part" in dataset:
            require(dataset, path, VARIABLES, ("run_drag",), window)
            return from_study(dataset.load(), margin)
        if "drag" not in dataset:
            raise InputError(f"{path}: it holds no drag; name drag.nc.")
        require_drag(dataset, path)
        dims = dataset["run_id"].dims
        if set(dims) != {"case", "seed"}:
            raise InputError(f"{path}: its runs are over {', '.join(dims)}; claims compare cases.")
        drag, flow, beside = dataset.load(), None, path.parent / "flow.nc"
    if beside.is_file():
        with open_lazily(beside) as dataset:
            if all(
                drag.indexes[name].equals(dataset.indexes.get(name)) for name in ("case", "seed")
            ):
                require(dataset, beside, {}, IRREGULARITY, window)
                flow = dataset.load()
    return from_sweep(drag, flow, margin)


VERBS = (test,)
