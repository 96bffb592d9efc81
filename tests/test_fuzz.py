"""Bad input at random; `python tests/fuzz.py 10000` takes longer, and knows slower kinds too."""

import subprocess
import sys

from conftest import posix


@posix
def test_bad_input_ends_in_a_sentence_and_loses_nothing():
    """No traceback, no hang, no file lost or left over, no damage that goes unnoticed."""
    import fuzz  # which needs what only POSIX has

    # a process of its own: the fuzzer forks, and the threads of other tests would be lost in its children
    command = [sys.executable, fuzz.__file__, "300", "0", "quick"]
    run = subprocess.run(command, cwd=fuzz.ROOT, text=True, capture_output=True)
    assert run.returncode == 0, run.stdout + run.stderr
