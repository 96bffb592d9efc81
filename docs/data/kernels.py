"""The code that decides how granules move, as one hash: what a released number is compared with.

python docs/data/kernels.py        that of today
"""

from pathlib import Path

from dem.base.source_hash import KERNELS, PACKAGE, code_hash, codes, files_of


def digest(package: Path = PACKAGE) -> str:
    """Hash of the code of a package that decides how granules move; comments and docstrings do not
    count.
    """
    return code_hash(codes(files_of(KERNELS, package), package.parent))[:16]


if __name__ == "__main__":
    print(digest())
