"""What a picture or a page shows."""

import re

import numpy as np
from PIL import Image

from dem.cli.show import plain_console


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
    """Finite places (k, 2) of the data that an axes shows: lines, bars, marks and areas."""
    data = [(line.get_transform(), line.get_xydata()) for line in axes.lines]
    for patch in axes.patches:
        corners = patch.get_patch_transform().transform_path(patch.get_path()).vertices
        data.append((patch.get_transform(), corners))
    for item in axes.collections:
        places = np.concatenate([path.vertices for path in item.get_paths()] or [np.empty((0, 2))])
        data += [(item.get_transform(), places), (item.get_offset_transform(), item.get_offsets())]
    of_data = [
        np.ma.filled(places, np.nan)
        for transform, places in data
        if all(transform.contains_branch_seperately(axes.transData))
    ]
    places = np.concatenate([*of_data, np.empty((0, 2))])
    return places[np.isfinite(places).all(axis=1)]


def assert_not_blank(picture):
    """Data are drawn in colour; axes, grid and words are grey."""
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    assert (np.ptp(pixels, axis=2) > 30).mean() > 1e-4, f"{picture} shows no data"


def text_of(table, width=1000):
    console = plain_console(width=width)
    with console.capture() as text:
        console.print(table)
    return text.get()
