"""Sentences on standard error, which may be closed or full: no work ends because of that."""

import sys
from contextlib import suppress


def say(sentence: str) -> None:
    """Show a sentence on a line of its own, even beside a progress bar."""
    if sys.stderr is None:  # it was closed when the process began
        return
    with suppress(OSError):  # a full disk, or nobody reads the pipe any more
        clear = "\r\x1b[2K" if sys.stderr.isatty() else ""
        print(f"{clear}{sentence}", file=sys.stderr, flush=True)
