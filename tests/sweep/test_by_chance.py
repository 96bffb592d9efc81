"""The quick form of what chance finds: a few examples of each, of which a night has thousands."""

import pytest
from bad_input import KINDS, make_good, spoil
from hypothesis import settings
from store_states import Sweeps

FEW = settings(max_examples=4, stateful_step_count=6)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    return make_good(tmp_path_factory.mktemp("good"))


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_bad_input_ends_in_a_sentence_and_loses_nothing(good, kind):
    spoil(good, kind, FEW)


@pytest.mark.quick
class TestSweeps(Sweeps.TestCase):
    """Two sweeps that share a store, planned, made, stopped, extended, pruned and damaged in any order."""

    settings = FEW
