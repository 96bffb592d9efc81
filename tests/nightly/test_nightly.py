"""What a night finds out: faults of the code that no quick test notices, and sweeps that are disturbed, and what chance finds."""

import re
import signal
import subprocess
import sys
import venv

import pytest
from bad_input import KINDS, make_good, spoil
from hypothesis import settings
from nightly import cluster, faults
from nightly.mutants import FAULTS, PROJECT, notices
from store_states import Sweeps
from workflows import environment

import studies


@pytest.mark.parametrize("fault", FAULTS, ids=str)
def test_a_quick_test_notices_a_fault_of_the_code(fault):
    assert notices(fault)


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A copy of the sources with a sweep that nobody disturbed."""
    sweep = {"case": ["c1", "d1", "c12"], "seed": [1, 2]}
    changes = {"sweep": sweep, "batch": 2, "figures": ["figure10", "figure13"]}
    sources = faults.Checkout(tmp_path_factory.mktemp("checkout"), **changes)
    sources.sweep("whole")
    sources.finish("whole")
    return sources


@pytest.mark.parametrize("fault", faults.FAULTS)
def test_a_disturbed_sweep_goes_on_to_the_same_bits(checkout, fault):
    faults.FAULTS[fault](checkout)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
@pytest.mark.parametrize(
    "name", [name for name in ("base", "column", "hopper") if name in studies.NAMES]
)
def test_a_study_that_is_stopped_goes_on_to_the_same_bits(checkout, name, number):
    faults.study_killed(checkout, name, number)


def ask(python, *words, **more):
    """Run a module in the project, which must succeed."""
    given = environment(PROJECT) | more
    subprocess.run([python, "-m", *words], cwd=PROJECT, env=given, check=True)


def test_no_index_of_a_kernel_is_out_of_its_array():
    ask(sys.executable, "pytest", "-n0", "tests/dynamics/test_twin.py", NUMBA_BOUNDSCHECK="1")


NUMBA = re.search('"(numba>=.*?)"', (PROJECT / "pyproject.toml").read_text())[1]


@pytest.mark.parametrize("numba", [NUMBA.replace(">", "="), NUMBA])
def test_the_quick_part_passes_with_the_oldest_and_the_newest_numba(tmp_path, numba):
    """Beside all else of the lock, but for what Numba chooses."""
    venv.create(tmp_path, with_pip=True)
    python = tmp_path / "bin/python"
    ask(python, "setup.install", "tests/requirements.txt")
    ask(python, "pip", "install", "-U", numba)
    ask(python, "pytest", "-m", "quick")


def test_a_dask_cluster_without_the_files_of_the_client_gives_the_same_values():
    cluster.main()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_bad_input_ends_in_a_sentence_and_loses_nothing(tmp_path_factory, kind):
    good = make_good(tmp_path_factory.mktemp("good"))
    spoil(good, kind, settings(settings.get_profile("night"), max_examples=500))


class TestSweeps(Sweeps.TestCase):
    settings = settings(settings.get_profile("night"), max_examples=1000, stateful_step_count=25)
