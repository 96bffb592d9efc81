"""Standard streams that are closed, full or of few letters: they end no work and lose no file."""

import errno
import io
import os
import sys

from dem.base.files import reason


class Outlet(io.FileIO):
    """A stream that takes everything; what cannot be written is lost, and `fault` says why."""

    fault: OSError | None = None

    def write(self, data):
        """Write, or remember the first reason why not."""
        try:
            return super().write(data)
        except OSError as error:
            self.fault = self.fault or error
            return len(data)


def open_streams() -> Outlet | None:
    """Open standard output and error again, so that no write to them fails; returns the output.

    Closed ones become files that take nothing: the next file to be opened would else get their
    number, and what is printed. None where the output is no file, as on a Windows console.
    """
    for number, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            # standard output is for results: it is opened to read, so that a write is a fault
            os.set_inheritable(os.open(os.devnull, mode), True)
    output, _ = _opened("stdout", 1), _opened("stderr", 2)
    return output


def _opened(name: str, number: int) -> Outlet | None:
    """Let sys.stdout or sys.stderr write to an outlet, as Python would."""
    stream = getattr(sys, name) or io.TextIOWrapper(io.BytesIO(), line_buffering=True)
    buffer = getattr(stream, "buffer", None)
    if type(getattr(buffer, "raw", buffer)) not in (io.FileIO, io.BytesIO):
        return None
    outlet = Outlet(number, "w", closefd=False)
    written = io.TextIOWrapper(
        outlet if type(buffer) is io.FileIO else io.BufferedWriter(outlet),
        stream.encoding,
        "backslashreplace",  # letters that the encoding lacks
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
    setattr(sys, name, written)
    return outlet


def nobody_reads() -> bool:
    """Whether standard output is a pipe whose reader has ended."""
    sys.stdout.flush()
    fault = getattr(getattr(sys.stdout.buffer, "raw", sys.stdout.buffer), "fault", None)
    return fault is not None and fault.errno == errno.EPIPE


def what_was_lost(outlet: Outlet | None) -> str | None:
    """A sentence if results that were shown went nowhere, unless their reader had enough of them."""
    sys.stdout.flush()
    if outlet is None or outlet.fault is None or outlet.fault.errno == errno.EPIPE:
        return None
    closed = outlet.fault.errno == errno.EBADF
    why = "it is closed" if closed else reason(outlet.fault)
    return f"standard output cannot be written ({why}); send it to a file that can, with > FILE."
