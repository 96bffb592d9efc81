"""The study of contacts: pairs whose contact is known, the methods that are compared, energy."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from reference import parting, potential

from conftest import places_shown
from dem.io.dataset import global_attributes, write
from studies.accuracy import bounces, contacts, definitions, layout_contacts, trials
from studies.accuracy.figures import accuracy_contacts
from studies.accuracy.pairs import (
    Contact,
    Pairs,
    difference,
    dot,
    draw,
    is_best,
    make_pairs,
    starts,
)

EPS = np.finfo(float).eps
METHODS = {method.name: method for method in contacts.USUAL.methods}
DEFAULT = METHODS[contacts.DEFAULT]
POLYGONS = [trials.polygon(sides) for sides in (16, 64, 256)]


def pairs_of(ratio, overlap, count=64):
    return make_pairs(np.random.default_rng(3), count, ratio, overlap)


def find(method, pairs, off=0.0):
    """Contacts by a method that starts up to `off` (rad) from the right normal."""
    return trials.find(method, pairs, starts(np.random.default_rng(4), pairs, off))


def tilt(one, two):
    """Angle (n,) between unit vectors, small, in rad."""
    return np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])


@pytest.mark.parametrize("ratio", [1.0, 1.375, 10.0])
@pytest.mark.parametrize("overlap", [1e-12, 0.3])
def test_constructed_contacts_agree_with_50_digits(ratio, overlap):
    """Overlap and normal of the constructed contact are those that 50 digits find."""
    pairs = pairs_of(ratio, overlap)
    assert max(difference(pairs, 5)) < 200 * np.finfo(np.longdouble).eps


def test_pairs_are_kept_where_no_other_direction_parts_them_sooner():
    """Kept pairs overlap by the least translation that parts them; the others by more."""
    pairs = draw(np.random.default_rng(5), 40, 10.0, 0.6)
    best = is_best(pairs)
    for k in [*np.flatnonzero(best)[:5], *np.flatnonzero(~best)[:5]]:
        least, _ = parting(pairs.d[k], pairs.own[k], pairs.other[k])
        excess = float(pairs.truth.overlap[k]) - least
        assert abs(excess) < 1e-5 if best[k] else excess > 1e-5


@pytest.mark.parametrize("name", METHODS)
def test_at_aspect_ratio_one_all_find_the_contact_of_discs(name):
    """On the line of centres, by what the radii exceed the distance; polygons nearly."""
    pairs = pairs_of(1.0, 0.1)
    contact = find(METHODS[name], pairs)
    radii, distance = pairs.own[:, 2] + pairs.other[:, 2], np.sqrt(dot(pairs.d, pairs.d))
    normal, overlap = pairs.d / distance[:, None], radii - distance
    polygon = METHODS[name].kind == "polygon"
    turn = np.pi / len(METHODS[name].solver.circle) if polygon else 1e-12
    assert_allclose(contact.overlap, overlap, atol=10 * EPS + radii.max() * turn**2)
    assert tilt(contact.normal, normal).max() < 1.01 * turn


def test_error_of_polygons_falls_with_order_two():
    """Four times the sides, a sixteenth of the error of the overlap."""
    pairs = pairs_of(1.375, 0.3)
    error = [np.abs(find(m, pairs).overlap - pairs.truth.overlap).max() for m in POLYGONS]
    assert_allclose(np.log(error[:-1]) - np.log(error[1:]), 2.0 * np.log(4.0), rtol=0.1)


@pytest.mark.parametrize("overlap", [1e-6, 1e-2, 0.3])
@pytest.mark.parametrize("name", METHODS)
def test_solvers_find_what_their_definitions_say(name, overlap):
    """Each solver agrees with a slow search in extended precision after its description alone:
    to rounding, the common normal to the cube of its tolerance."""
    method = METHODS[name]
    slack = 10.0 * method.solver.tolerance**3 if method.kind == "common normal" else 0.0
    for ratio in (1.125, 2.0):
        pairs = pairs_of(ratio, overlap)
        contact, right = find(method, pairs), method.definition(pairs)
        there = ~np.isnan(contact.overlap)
        assert np.array_equal(there, ~np.isnan(right.overlap))
        apart = contact.point - right.point
        assert np.abs(contact.overlap - right.overlap)[there].max(initial=0.0) < 2e-14 + slack
        assert (
            tilt(contact.normal, right.normal)[there].max(initial=0.0)
            < 1e-15 / overlap + 2e-14 + slack
        )
        assert np.abs(apart[there]).max(initial=0.0) < 2e-14 + slack


@pytest.mark.parametrize("name", METHODS)
def test_no_contact_where_there_is_a_gap(name):
    """No method finds a contact of ellipses that are apart."""
    assert np.isnan(find(METHODS[name], pairs_of(1.375, -1e-6), 1e-2).overlap).all()


@pytest.mark.parametrize("off", [0.0, 1e-4])
def test_common_normal_errs_by_rounding_at_warm_starts(off):
    """From a carried normal the overlap is right to ten units in the last place of a radius."""
    for ratio in (1.0, 1.125, 1.375):
        for overlap in (1e-9, 1e-4, 0.3):
            pairs = pairs_of(ratio, overlap, 256)
            error = find(DEFAULT, pairs, off).overlap - pairs.truth.overlap
            assert np.abs(error).max() < 10 * EPS


@pytest.mark.parametrize("ratio", [1.125, 2.0])
@pytest.mark.parametrize("overlap", [1e-9, 1e-2, 0.3])
def test_outlines_cross_at_the_ends_of_the_chord(ratio, overlap):
    """The ends lie on both outlines, and the normal of the intersection is across their chord."""
    pairs = pairs_of(ratio, overlap)
    ends = definitions.crossings(*definitions.exact(pairs))
    for own, other, d, first, second in zip(pairs.own, pairs.other, pairs.d, *ends, strict=True):
        points = np.array([first, second], float)
        assert_allclose(potential(own, points), 0.0, atol=1e-13)
        assert_allclose(potential(other, points - d), 0.0, atol=1e-13)
    chord = (ends[1] - ends[0]).astype(float)
    along = dot(
        find(trials.INTERSECTION, pairs).normal, chord / np.sqrt(dot(chord, chord))[:, None]
    )
    assert_allclose(along, 0.0, atol=1e-9)


def test_outlines_that_cross_four_times_have_no_chord():
    """A cross of two ellipses has no contact by intersection, rather than any."""
    cross = np.tile([1.0, 0.0, 2.0, 1.0], (64, 1)), np.tile([0.0, 1.0, 2.0, 1.0], (64, 1))
    nothing = Contact(np.full(64, np.nan), *np.full((2, 64, 2), np.nan))
    pairs = Pairs(np.tile([0.05, 0.02], (64, 1)), *cross, nothing)
    assert np.isnan(trials.find(trials.INTERSECTION, pairs, pairs.d).overlap).all()
    assert np.isnan(definitions.crossing(pairs).overlap).all()


def test_pareto_front_holds_what_no_other_kind_beats():
    """Slower and less exact than one of another kind is not on the front; of the same kind, it is."""
    names = ["fast", "exact", "slow sibling of fast", "beaten"]
    each = ("contact_method",)
    dataset = xr.Dataset(
        {
            "contact_time": ((*each, "contact_repeat"), [[1.0], [2.0], [3.0], [3.0]]),
            "contact_overlap_error": (each, [1e-2, 1e-6, 1e-2, 1e-2]),
            "contact_kind": (each, ["a", "b", "a", "c"]),
        },
        {"contact_method": names},
    )
    assert contacts.pareto(dataset).values.tolist() == [True, True, False, False]
    dataset = dataset.drop_sel(contact_method="exact")
    assert contacts.pareto(dataset).values.tolist() == [True, True, False]


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A small study, written and read again."""
    values = contacts.measure(contacts.SMOKE) | bounces.measure(bounces.SMOKE)
    path = tmp_path_factory.mktemp("study") / "contacts.nc"
    write(path, values, global_attributes("test", "test"), layout_contacts.VARIABLES)
    with xr.open_dataset(path) as dataset:
        return dataset.load()


def test_the_study_has_all_its_variables(study):
    """All that the layout names; what has no memory is the same from every start."""
    assert set(study.variables) == set(layout_contacts.VARIABLES)
    for name, (dims, _, _) in layout_contacts.VARIABLES.items():
        assert study[name].dims == dims
    chord = study["contact_time"].sel(contact_method="geometric potential")
    assert (chord == chord.isel(contact_start=0)).all()
    assert not contacts.in_the_beds(study)["contact_start"].isin([contacts.COLD]).any()


def test_the_figure_shows_the_errors_and_times_of_the_study(study):
    """Three panels, each with its reading as a title and with data."""
    panels = accuracy_contacts.plot(study).axes
    assert len(panels) == 3 and all(panel.get_title(loc="left") for panel in panels)
    assert all(len(places_shown(panel)) >= study.sizes["contact_method"] for panel in panels[:2])
    assert len(places_shown(panels[2])) >= study.sizes["bounce_number"]


def test_the_default_keeps_the_energy_of_bouncing_ellipses(study):
    """Frictionless elastic bounces by the common normal change the energy by next to nothing."""
    change = (
        study["bounce_energy"].sel(bounce_method="common normal", bounce_aspect_ratio=1.375) - 1
    )
    assert study["bounce_number"].max() >= 30
    assert float(np.abs(change).max()) < 1e-4
