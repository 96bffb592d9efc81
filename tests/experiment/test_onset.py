"""The onset of jamming: what carries a bed there, what lies below and above, lines over the size."""

import numpy as np
import pytest
import xarray as xr
from project import ROOT

from dem.analysis.onset import LEAST, limits
from dem.base.errors import InputError
from dem.dynamics.contact_output import ContactList
from dem.experiment.bed import room_of
from dem.experiment.config import parse
from dem.experiment.kinds import jamming, onset
from dem.figures.catalogue import FIGURES
from dem.figures.onset import plot
from dem.packing.compaction import Press
from dem.sweep.config import load

pytestmark = pytest.mark.quick

SWEEP = ROOT / "studies/onset/sweep.yaml"
if not SWEEP.is_file():
    pytest.skip("needs the study onset", allow_module_level=True)
SWEEP = load(SWEEP)


def bed(ratio=1.0, granules=40, seed=1, **changes):
    """A run of the sweep with few granules."""
    width = 0.98e-3 * np.sqrt(granules)
    new = {"shapes.e.aspect_ratio": ratio, "shapes.e.granules": granules, "box_width": width}
    new |= {"shapes.e.kind": "disc", "shapes.e.aspect_ratio": None} if ratio == 1.0 else {}
    return SWEEP.changed(new | changes, "e").replicate("e", 3900.0, seed)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_discs_jam_with_as_many_contacts_as_degrees_of_freedom(seed):
    """Two a disc; two less because the whole may move, one more because the bed bears a load."""
    result = onset.run(bed(1.0, seed=seed))
    discs = 40 - result["onset_rattlers"]
    assert result["onset_contacts"] == 2 * discs - 1
    assert 0.80 < result["onset_fraction"] < 0.87


@pytest.mark.parametrize("ratio", [1.1, 1.5])
def test_ellipses_jam_with_fewer_contacts_than_degrees_of_freedom(ratio):
    """Yet with more than discs, which do not feel that they turn."""
    result = onset.run(bed(ratio))
    ellipses = 40 - result["onset_rattlers"]
    assert 2 * ellipses - 1 < result["onset_contacts"] < 3 * ellipses - 1


LINEAR = {"contact.law": "linear", "periodic": "x"}  # discs between a floor and a lid


@pytest.mark.parametrize(("ratio", "changes", "power"), [(1.3, {}, 1.5), (1.0, LINEAR, 1.0)])
def test_a_bed_bears_no_load_below_the_onset_and_that_of_its_law_above(ratio, changes, power):
    """The load goes as the distance from the onset to the power of 3/2 under Hertz's law, in proportion to it
    under a linear one."""
    replicate, soft = bed(ratio, **changes), onset.JAMMED ** (power / 1.5 - 1.0)
    press, fraction = Press(*room_of(replicate)), onset.run(replicate)["onset_fraction"]
    while press.fraction < fraction + 1e-3:  # as the onset was found
        press.press(press.fraction + onset.STEP, onset.GROWN * soft, onset.PATIENCE)
    far, near = (press.press(fraction + gap, 1e-10, onset.PATIENCE) for gap in (4e-4, 1e-4))
    assert far / near == pytest.approx(4.0**power, rel=0.1)
    assert press.press(fraction - 1e-4, 1e-12, onset.PATIENCE) < 1e-3 * near


def test_the_onset_is_just_below_where_the_line_of_greater_loads_meets_zero():
    """The experiment jamming fits that line to beds that are farther beyond the onset."""
    replicate = bed(1.0, granules=80)
    wide = jamming.run(replicate)["jam_fraction"]
    assert onset.run(replicate)["onset_fraction"] == pytest.approx(wide, abs=0.01)


def contacts(*pairs):
    """Contacts between granules by number, as Simulation.contacts gives them."""
    first, second = np.array(pairs).T
    fields = dict.fromkeys(ContactList._fields, np.zeros(len(pairs)))
    return ContactList(**fields | {"granule": first, "partner": second})


def test_granules_that_too_few_contacts_hold_are_rattlers():
    """A chain on a firm square of four goes link by link; walls and the cylinder hold granules."""
    square = (0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)
    chain = (3, 4), (4, 5), (5, 6), (5, 2), (5, 1), (6, 4)
    assert onset.backbone(contacts(*square), 8).tolist() == [True] * 4 + [False] * 4
    assert onset.backbone(contacts(*square, (3, 4), (4, 5), (5, 6), (5, 3)), 8)[4:].sum() == 0
    backbone = onset.backbone(contacts(*square, *chain, (6, 0), (4, -1)), 8)
    assert backbone[4:].tolist() == [True, True, True, False]


# Configuration


def values(**changes):
    return bed().configuration.values() | changes


def test_only_what_draws_no_cylinder_may_lack_one():
    with pytest.raises(InputError, match="cylinder is missing; the experiment drag needs it"):
        parse(values(experiment="drag"))
    assert parse(values(experiment="jamming")).cylinder is None


def test_the_onset_is_that_of_beds_without_friction():
    packing = values()["packing"] | {"friction": 0.3}
    with pytest.raises(
        InputError, match=r"packing\.friction is 0\.3; the experiment onset needs 0"
    ):
        parse(values(packing=packing))


# Lines over the size


def swept(fraction, contact, granules=(50, 100, 200), beds=4, noise=1e-3, seed=1):
    """A file of beds that jam at a packing fraction, and on contacts per granule, of N."""
    rng = np.random.default_rng(seed)
    n = np.array(granules)[None, :, None]
    dims = "shape", "ratio", "size", "seed"
    shape = 1, 2, len(granules), beds
    scatter = noise * rng.standard_normal(shape) * np.sqrt(100.0 / n)
    return xr.Dataset(
        {
            "onset_fraction": (dims, fraction(n) + scatter),
            "onset_contacts": (dims, np.broadcast_to(0.5 * n * contact(n), shape)),
            "onset_rattlers": (dims, np.zeros(shape)),
            "run_id": (dims, np.full(shape, "x")),
        },
        {
            "granules": (("shape", "size"), [list(granules)]),
            "aspect_ratio": (("shape", "ratio"), [[1.0, 1.5]]),
            "seed": np.arange(beds),
        },
    )


def test_lines_find_what_beds_without_end_have():
    result = limits(swept(lambda n: 0.84 - 0.05 * n**-0.5, lambda n: 4.0 - 2.0 / n, noise=0.0))
    for fraction, contact in zip(result.fraction, result.coordination, strict=True):
        assert fraction == pytest.approx((0.84, 0.84, 0.84))
        assert contact == pytest.approx((4.0, 4.0, 4.0))


def test_intervals_hold_the_truth_as_often_as_they_say():
    hits = []
    for seed in range(100):
        result = limits(swept(lambda n: 0.84 - 0.05 * n**-0.5, lambda n: 4.0 - 2.0 / n, seed=seed))
        hits += [interval.low < 0.84 < interval.high for interval in result.fraction]
    assert 0.88 <= np.mean(hits) <= 0.99


def test_rattlers_count_neither_as_granules_nor_for_contacts():
    beds = swept(lambda n: 0.84 + 0.0 * n, lambda n: 4.0 - 2.0 / n, noise=0.0)
    half = beds.assign(
        onset_rattlers=0.5 * beds["granules"] + 0.0 * beds["onset_rattlers"],
        onset_contacts=0.5 * beds["onset_contacts"],
    )
    assert limits(half).contacts == pytest.approx(limits(beds).contacts)
    assert limits(half).rattlers == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("granules", "beds", "words"),
    [
        ((50, 100), 4, "it has 2 and 4"),
        ((50, 100, 200), 2, "it has 3 and 2"),
    ],
)
def test_too_few_beds_for_a_line_are_refused(granules, beds, words):
    with pytest.raises(InputError, match=words):
        limits(swept(lambda n: 0.84 + 0.0 * n, lambda n: 4.0 + 0.0 * n, granules, beds))
    assert FIGURES["onset"].axes == {"granules": LEAST, "seed": LEAST}


@pytest.mark.parametrize("sizes", [(50, 100, 200), tuple(50 * 2**k for k in range(9))])
def test_the_figure_shows_every_size_in_a_look_of_its_own_and_the_limit(sizes):
    figure = plot(swept(lambda n: 0.84 - 0.05 * n**-0.5, lambda n: 4.0 - 2.0 / n, sizes))
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [*(f"{size} granules" for size in sizes), "infinitely many"]
    drawn = [line for line in figure.axes[0].lines if "granules" in line.get_label()]
    assert len({(line.get_marker(), line.get_markerfacecolor()) for line in drawn}) == len(sizes)
