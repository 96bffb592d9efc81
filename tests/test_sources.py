"""Which files a module depends on: read from its imports, those inside functions too."""

import subprocess
import sys

import pytest

from dem.base.sources import ROOT, closure
from dem.figures import captions


def test_a_figure_depends_on_itself_and_its_style():
    for name in captions():
        assert {f"dem/figures/{name}.py", "dem/figures/style.py"} <= set(
            closure(f"dem.figures.{name}")
        )
    assert "dem/analysis/flow/verdict.py" in closure("dem.figures.irregularity")
    assert "dem/figures/figure08.py" not in closure("dem.figures.figure07")


@pytest.mark.parametrize(
    "name", ["dem.figures.irregularity", "dem.studies.claims.verdicts", "dem.experiment.drag"]
)
def test_all_that_python_loads_is_found(name):
    """What importing a module loads of the package is among its sources."""
    words = f"import sys, {name}; print(*[m.__file__ for n, m in sys.modules.items() if n.partition('.')[0] == 'dem'])"
    run = subprocess.run([sys.executable, "-c", words], cwd=ROOT, text=True, capture_output=True, check=True)  # fmt: skip
    loaded = {path.removeprefix(f"{ROOT}/") for path in run.stdout.split()}
    assert loaded <= set(closure(name))


def test_a_module_that_is_not_of_the_package_is_refused():
    for name in ("numpy", "dem.nothing", "dem.base.errors.InputError"):
        with pytest.raises(ValueError, match="module is"):
            closure(name)
