"""What a picture or a page shows."""

import re

import numpy as np
from matplotlib.container import ErrorbarContainer
from matplotlib.text import Text
from PIL import Image

from dem.cli.show import PlainConsole


def assert_alone(browser):
    """The page that is open has asked for nothing but itself, and no script has failed."""
    events = [
        line["message"]
        for line in browser.get_log("performance")
        if "Network.requestWillBeSent" in line["message"]
    ]
    assert events and all(re.search(r'"url":"(file|data|blob):', one) for one in events), events
    assert not [line for line in browser.get_log("browser") if line["level"] == "SEVERE"]


def places_shown(axes):
    """Places (k, 2) of the lines, marks and areas of an axes."""
    areas = [path.vertices for item in axes.collections for path in item.get_paths()]
    return np.concatenate([*(line.get_xydata() for line in axes.lines), *areas])


def assert_not_blank(picture):
    """Data are drawn in colour; axes, grid and words are grey."""
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    assert (np.ptp(pixels, axis=2) > 30).mean() > 1e-4, f"{picture} shows no data"


def text_of(table, width=1000):
    console = PlainConsole(width=width)
    with console.capture() as text:
        console.print(table)
    return text.get()


def intervals_shown(axes):
    """Rows (k, 4) of an axes: x, value, low and high of each error bar that stands, by x; low and high are
    the value where it has none."""
    rows = []
    for container in axes.containers:
        if isinstance(container, ErrorbarContainer):
            line, _, (bars,) = container.lines
            for (x, y), ends in zip(line.get_xydata(), bars.get_segments(), strict=True):
                low, high = ends[:, 1] if len(ends) else (y, y)
                rows.append([x, y, low, high])
    return np.array(sorted(rows)).reshape(-1, 4)


def boxes_shown(collection):
    """Lower left and upper right corner (k, 2, 2) around each outline."""
    return np.array([path.get_extents().get_points() for path in collection.get_paths()])


def words_shown(figure):
    """All words of a figure: titles, labels, ticks, legends, notes."""
    texts = [text.get_text() for text in figure.findobj(Text)]
    return "\n".join(" ".join(text.split()) for text in texts).replace("\N{MINUS SIGN}", "-")
