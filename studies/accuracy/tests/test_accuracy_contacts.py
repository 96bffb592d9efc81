"""The study of contacts: pairs whose contact is known, the methods that are compared, energy."""

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from reference import parting

from conftest import places_shown
from dem.io.dataset import global_attributes, write
from studies.accuracy import bounces, contacts, trials
from studies.accuracy.figures import accuracy_contacts
from studies.accuracy.layout import CONTACTS
from studies.accuracy.pairs import dot, draw, is_best, make_pairs, starts

EPS = np.finfo(float).eps
METHODS = {method.name: method for method in contacts.USUAL.methods}
DEFAULT = METHODS[contacts.DEFAULT]


def pairs_of(ratio, overlap, count=64):
    return make_pairs(np.random.default_rng(3), count, ratio, overlap)


def find(method, pairs, off=0.0):
    """Contacts by a method that starts up to `off` (rad) from the right normal."""
    return trials.find(method, pairs, starts(np.random.default_rng(4), pairs, off))


def tilt(one, two):
    """Angle (n,) between unit vectors, small, in rad."""
    return np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])


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
    """On the line of centres, by what the radii exceed the distance."""
    pairs = pairs_of(1.0, 0.1)
    contact = find(METHODS[name], pairs)
    radii, distance = pairs.own[:, 2] + pairs.other[:, 2], np.sqrt(dot(pairs.d, pairs.d))
    normal, overlap = pairs.d / distance[:, None], radii - distance
    assert_allclose(contact.overlap, overlap, atol=10 * EPS)
    assert tilt(contact.normal, normal).max() < 1.01e-12


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


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """A small study, written and read again."""
    values = contacts.measure(contacts.SMOKE) | bounces.measure(bounces.SMOKE)
    path = tmp_path_factory.mktemp("study") / "contacts.nc"
    write(path, values, global_attributes("test", "test"), CONTACTS)
    with xr.open_dataset(path) as dataset:
        return dataset.load()


def test_the_study_has_all_its_variables(study):
    """All that the layout names; what has no memory errs alike from every start."""
    assert set(study.variables) == set(CONTACTS)
    for name, (dims, _, _) in CONTACTS.items():
        assert study[name].dims == dims
    chord = study["contact_overlap_error"].sel(contact_method="geometric potential")
    assert (chord == chord.isel(contact_start=0)).all()
    assert not contacts.in_the_beds(study)["contact_start"].isin([contacts.COLD]).any()


def test_the_figure_shows_the_errors_and_times_of_the_study(study):
    """Three panels, each with a title and with data."""
    panels = accuracy_contacts.plot(study).axes
    assert len(panels) == 3 and all(panel.get_title(loc="left") for panel in panels)
    assert all(len(places_shown(panel)) >= 2 for panel in panels[:2])
    assert len(places_shown(panels[2])) >= study.sizes["bounce_number"]


def test_the_default_keeps_the_energy_of_bouncing_ellipses(study):
    """Frictionless elastic bounces by the common normal change the energy by next to nothing."""
    change = (
        study["bounce_energy"].sel(bounce_method="common normal", bounce_aspect_ratio=1.375) - 1
    )
    assert study["bounce_number"].max() >= 30
    assert float(np.abs(change).max()) < 1e-4
