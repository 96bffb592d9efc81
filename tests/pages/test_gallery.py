"""The gallery of the site, which its build draws."""

import sys

import pytest
from project import ROOT

from studies import catalogue

sys.path.append(str(ROOT / "docs/_ext"))
import gallery

pytestmark = pytest.mark.quick


def test_each_film_picture_and_figure_of_the_gallery_has_a_place_of_its_own():
    """A study may have a film and a figure of one name."""
    files = [*gallery.PICTURES, *(f"{name}.png" for name in catalogue.figures())]
    assert len({gallery.label(file) for file in files}) == len(files)
