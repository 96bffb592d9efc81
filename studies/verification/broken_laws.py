"""Which case notices which broken law?  python studies/verification/broken_laws.py [NUMBER ...]

Each law is broken by one edit of a copy of the project, in which the cases of one contact then run.
The script writes studies/verification/laws.json, which the page shows: by law and case how many
numbers fail, or the error that ends the case. Kernels are compiled for each law: some two minutes
of a processor each.
"""

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
from nightly.mutants import faulty_copy  # noqa: E402

from dem.base import provenance  # noqa: E402
from docs.data.kernels import digest  # noqa: E402

FILE = ROOT / "studies/verification/laws.json"
CASES = (
    "falling",
    "stacked",
    "rolling",
    "incline",
    "normal_impact",
    "restitution",
    "oblique",
    "spinning",
    "off_centre",
)
SPRING, RADII = "contacts/springs.py", "contacts/effective.py"
RESTITUTION = "contacts/restitution.py"
RESPONSE, WALL = "contacts/response.py", "contacts/geometry.py"
LIST, SCENE, DISC = "dynamics/contact_constants.py", "dynamics/assembly.py", "shapes/disc.py"


class Law(NamedTuple):
    """A law that is broken: in `file` of dem/, `right` becomes `wrong`; `asks`: a case that notices it."""

    file: str
    kind: str
    right: str
    wrong: str
    asks: str


LAWS = (
    Law(SPRING, "friction of the wrong sign",
        "spring * kept - stiffness", "spring * kept + stiffness", "rolling"),
    Law(RESPONSE, "half of friction",
        "friction[friction_at + k + COEFFICIENT] * normal",
        "0.5 * friction[friction_at + k + COEFFICIENT] * normal", "rolling"),
    Law(SPRING, "tangential spring not rescaled on unloading",
        "spring * kept -", "spring -", "oblique"),
    Law(RESTITUTION, "damping by the formula of a contact that pulls",
        "(math.pi - 2.0 * psi) *", "math.pi *", "restitution"),
    Law(RESPONSE, "a contact that pulls at its end",
        "mean * -rate, 0.0)", "mean * -rate, -math.inf)", "restitution"),
    Law(RADII, "mean of the radii for R*",
        "one * two / (one + two)", "0.5 * (one + two)", "normal_impact"),
    Law(LIST, "radius of the granule for R* at the cylinder",
        "bed.solid_radius[b]", "0.0", "spinning"),
    Law(SCENE, "half of the mass in the dashpot",
        "mass=scene.mass[", "mass=0.5 * scene.mass[", "restitution"),
    Law(SCENE, "half of the mass in motion",
        "1.0 / scene.mass,", "2.0 / scene.mass,", "normal_impact"),
    Law(DISC, "inertia of a sphere for discs",
        "0.5 * self.radius**2", "0.4 * self.radius**2", "rolling"),
    Law(DISC, "lever of the full radius between granules",
        "half = 0.5 * overlap", "half = 0.0 * overlap", "oblique"),
    Law(WALL, "lever of the full radius at a wall",
        "reach - 0.5 * overlap", "reach - 0.0 * overlap", "rolling"),
)  # fmt: skip
ASK = """
import json, sys
from studies.verification.results import run
found = {}
for name in sys.argv[1:]:
    try:
        found[name] = sum(not row.passed for row in run(name)[0])
    except Exception as error:
        found[name] = type(error).__name__
print(json.dumps(found))
"""


def notices(law: Law, *cases: str) -> dict[str, int | str]:
    """How many numbers of each case fail where a law is broken, or the error that ends it."""
    with TemporaryDirectory() as folder:
        copy = faulty_copy(law, Path(folder))
        environment = os.environ | {
            "NUMBA_CACHE_DIR": str(copy / ".numba"),
            "PYTHONPATH": str(copy),
        }
        process = subprocess.run(
            [sys.executable, "-P", "-c", ASK, *cases],
            cwd=copy,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert process.returncode == 0, process.stderr
        return json.loads(process.stdout)


def main():
    words = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    words.add_argument("numbers", nargs="*", type=int, help="of the laws; all if there is none")
    revision = provenance.git_revision()
    for number in words.parse_args().numbers or range(len(LAWS)):
        counts = notices(LAWS[number], *CASES)
        data = json.loads(FILE.read_text()) if FILE.exists() else {"laws": {}, "revisions": {}}
        data["laws"][LAWS[number].kind] = counts
        data["revisions"][LAWS[number].kind] = revision
        data.setdefault("kernels", {})[LAWS[number].kind] = digest()
        FILE.write_text(json.dumps(data, indent=1) + "\n")
        print(LAWS[number].kind, counts, flush=True)


if __name__ == "__main__":
    main()
