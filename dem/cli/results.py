"""Command line, results: `dem info`, `means`, `figure`, `draw`, `report`."""

from pathlib import Path

from dem.cli.options import OUTPUT, FolderOption, TextOption, argument, option, writes
from dem.cli.show import draw_figure, print_or_write
from dem.io.progress import bar


def info(
    data: argument(Path, "drag.nc or a file of runs."),
    output: TextOption = None,
):
    """Print what a file of results holds: cases, mean drag, scatter and intervals.

    Example: dem info results/drag.nc
    """
    with bar(f"reading {data}"):
        from dem.report.info import summary  # this may take longer than the file

        table = summary(data)
    print_or_write(table, output)


def means(
    data: argument(Path, "drag.nc, or another combined file."),
    other: argument(Path | None, "Another one, to set the means of both side by side.") = None,
    quantity: option(
        str | None,
        "What is shown, or compared with the other file; drag, or the first of the file, if absent.",
        "--of",
    ) = None,
    output: option(
        Path | None,
        "Table to write (.csv or .nc); the terminal if absent.",
        *OUTPUT,
        callback=writes(),
    ) = None,
):
    """Means of the runs of a file, one row a point; or of two files, with their ratio.

    Example: dem means results/drag.nc -o means.csv
    """
    from dem.analysis import means as analysis
    from dem.analysis.tables import TextTable
    from dem.report.info import brief

    with bar(f"reading {data}"):
        if other is None:
            table = analysis.means(data, None if output else quantity, every=bool(output))
        else:
            table = analysis.compared(data, other, quantity)
    if output is not None:
        analysis.write_means(table, output)
        return
    print_or_write(TextTable(brief(table)), None)


def figure(
    name: argument(str, "Figure name, e.g. figure13, or all; an unknown name prints the list."),
    data: argument(Path, "drag.nc, snapshots.nc, shear.nc or onset.nc."),
    output: FolderOption = None,
    of: option(
        str | None, "Quantity to plot, only for the figure sweep; default: drag, or the first."
    ) = None,
):
    """Draw a figure of results, as SVG and PNG.

    Example: dem figure figure13 results/drag.nc
    """
    from dem.figures.catalogue import FIGURES

    draw_figure(name, data, output, FIGURES, of)


def rft(
    data: argument(Path, "scene.nc of a sweep like config/rft.yaml."),
    output: option(
        Path | None,
        "File to write (.json or .nc); the terminal if absent.",
        *OUTPUT,
        callback=writes(".json", ".nc"),
    ) = None,
):
    """Coefficients of resistive force theory (N/m3), from the forces on a plate by angle and direction.

    Example: dem rft results/rft/scene.nc -o sand.json
    """
    from dem.analysis import rft as analysis
    from dem.analysis.tables import TextTable
    from dem.io.lazily import open_lazily

    with bar(f"reading {data}"), open_lazily(data) as dataset:
        plates = analysis.measured(dataset)
        result = analysis.dataset_of(plates, analysis.fitted(plates), dataset.attrs)
    if output is not None:
        analysis.write(result, output)
        return
    columns = result[["coefficient", "half_interval", "generic"]].to_dataframe().reset_index()
    print_or_write(TextTable(columns), None)


def draw(
    run: argument(Path, "drag.nc, or a file of runs.", metavar="RUN"),
    output: option(Path, "Output file; its extension selects the format.", *OUTPUT),
    select: argument(
        list[str] | None,
        "Which run, by values that differ between runs, such as case=c1 seed=1.",
        metavar="NAME=VALUE",
    ) = None,
    at: option(
        float | None, "Displacement of a picture, m, or time in a scene, s; the middle if absent."
    ) = None,
    color: option(str, "Colour by speed, force, layer or cluster.") = "speed",
    forces: option(
        bool, "Draw contact forces as lines; wide lines are large forces.", "--forces"
    ) = False,
    shapes: option(
        str | None,  # a Path would have to be a file
        "Folder of files of shapes of your own, whose code then runs.",
        metavar="FOLDER",
    ) = None,
):
    """Draw one run: a film (.mp4, .gif), a picture (.png, .svg, .pdf), or all for ParaView (.pvd).

    Example: dem draw results/drag.nc case=c1 seed=1 -o c1.mp4
    """
    from dem.analysis.one_run import read_snapshots
    from dem.base.errors import InputError
    from dem.base.files import check_output
    from dem.figures.export import export
    from dem.figures.film import FILMS, PICTURES, film, picture

    output = check_output("output", output, (*FILMS, *PICTURES, ".pvd"))
    if at is not None and output.suffix.lower() not in PICTURES:
        raise InputError(
            f"at is {at:g} and output {output}; a film and .pvd show all, leave at out."
        )
    with bar("reading the run"):
        motion = read_snapshots(run, select or [], shapes)
    with bar(f"drawing {output}", 1.0) as update:
        if output.suffix.lower() in FILMS:
            film(motion, output, color, forces, update)
        elif output.suffix.lower() in PICTURES:
            picture(motion, output, at, color, forces)
        else:
            export(motion, output, update)


def report(
    data: argument(Path, "drag.nc; the page shows the files next to it."),
    output: option(Path, "HTML file to write.", *OUTPUT, callback=writes(".html")),
):
    """Write all results as one HTML page, which opens without a network.

    Example: dem report results/drag.nc -o report.html
    """
    from dem.report.build import build

    with bar("writing the report"):
        build(data, output)


VERBS = (info, means, figure, rft, draw, report)
