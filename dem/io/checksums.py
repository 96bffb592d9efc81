"""A checksum at the end of a file, behind what its format reads: damage is noticed before reading.

It covers all bytes: filters of netCDF guard arrays only, and a damaged header
can keep HDF5 busy for ever. Who changes the file with another program takes the checksum away.
"""

from hashlib import file_digest, sha256
from pathlib import Path

MARK = b"\nsha256 "
LENGTH = len(MARK) + 2 * sha256().digest_size
BLOCK = 1 << 20  # bytes that are read at a time


class Changed(ValueError):
    """A file does not hold what was written."""


def seal(path: Path) -> None:
    """Add the checksum of a file that has been written."""
    with Path(path).open("rb+") as file:
        file.write(MARK + file_digest(file, sha256).hexdigest().encode())


def is_sealed(path: Path) -> bool:
    """Whether a file has a checksum; raises Changed if its bytes have another."""
    checksum = sha256()
    with Path(path).open("rb") as file:
        size = file.seek(0, 2) - LENGTH
        if size < 0:
            return False
        file.seek(size)
        mark, stored = file.read(len(MARK)), file.read()
        if mark != MARK:
            return False
        file.seek(0)
        for start in range(0, size, BLOCK):
            checksum.update(file.read(min(BLOCK, size - start)))
    if stored != checksum.hexdigest().encode():
        raise Changed("its checksum is another")
    return True
