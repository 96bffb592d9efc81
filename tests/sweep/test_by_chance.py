"""The quick form of what chance finds: a few examples of each, of which a night has thousands."""

import pytest
from hypothesis import settings
from nightly import test_fuzz
from nightly.test_fuzz import good  # noqa: F401, a fixture
from nightly.test_store_states import Sweeps


@pytest.mark.parametrize("kind", test_fuzz.KINDS, ids=lambda kind: kind.__name__)
def test_bad_input_ends_in_a_sentence_and_loses_nothing(good, kind):  # noqa: F811
    test_fuzz.spoil(good, kind, settings(settings.get_profile("suite"), max_examples=3))


class TestSweeps(Sweeps.TestCase):
    """Two sweeps that share a store, planned, made, stopped, extended, pruned and damaged in any order."""

    settings = settings(settings.get_profile("suite"), max_examples=3, stateful_step_count=20)
