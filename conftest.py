"""Which tests go together, how hypothesis searches, and the folders, checkouts and browser that several tests share."""

import os
import shlex
import shutil
import sys

# Tests run side by side. Threads of OpenBLAS would spin while they wait for each other.
os.environ["OPENBLAS_NUM_THREADS"] = "1"

import hypothesis
import pytest
from beds import KINDS
from filelock import FileLock
from project import ROOT
from workflows import completed, run

pytest_plugins = ["kinds"]

# Compiling takes seconds, so no deadlines; the same examples each time, so no surprises.
hypothesis.settings.register_profile("suite", deadline=None, derandomize=True, max_examples=100)
hypothesis.settings.register_profile("night", deadline=None, max_examples=2000)
# The same examples, but none is made smaller, which takes minutes: tests/nightly/mutants.py asks only whether one fails.
hypothesis.settings.register_profile(
    "mutants",
    hypothesis.settings.get_profile("suite"),
    phases=[hypothesis.Phase.explicit, hypothesis.Phase.generate],
)
hypothesis.settings.load_profile("suite")


# Groups of tests that take longest, in the order in which they begin; one that begins last would
# leave a processor idle. What two groups side by side both need is compiled twice, so the first on one
# worker are those of discs, and on the other those of other shapes.
LONGEST = shlex.split(
    "disc superellipse ellipse dumbbell clump claims test_workflow test_compilation test_promises "
    "test_plot test_pages test_plugins test_workers test_studies test_runs test_damage test_faults"
)


# Parameters of quick tests that take long, by a part of the name of the test.
SLOW = shlex.split(
    "superellipse- [superellipse] page_on_stress jam_with close_one[ellipse [e3] "
    "[figure09] [figure10] [figure12] paraview[d1] imports[observable] imports[shape] imports[law]"
)


def pytest_ignore_collect(collection_path, config):
    """Files without quick tests are not even read for them."""
    if config.option.markexpr == "quick" and collection_path.suffix == ".py":
        return "quick" not in collection_path.read_text(encoding="utf-8") or None
    return None


@pytest.hookimpl(tryfirst=True)  # before pytest-xdist reads the groups
def pytest_collection_modifyitems(config, items):
    """Tests of one kind of granule, by parameter or by file, on one processor: its kernels are then
    compiled but once."""
    groups = {}
    for item in items:
        parameters, stem = item.name.lower().partition("[")[2], item.path.stem
        group = next((kind for kind in KINDS if kind in parameters + stem), stem)
        group = stem if "small_checkout" in item.fixturenames else group  # with files of each other
        groups[item] = "claims" if "checkout_with_claims" in item.fixturenames else group
        item.add_marker(pytest.mark.xdist_group(groups[item]))
    if config.option.markexpr == "quick":
        items[:] = [item for item in items if not any(part in item.name for part in SLOW)]
    if "PYTEST_XDIST_WORKER" in os.environ:
        order = {group: index for index, group in enumerate(LONGEST)}
        items.sort(key=lambda item: order.get(groups[item], len(order)))


CHROMIUM = shlex.split(
    "--headless --no-sandbox --disable-gpu --no-first-run --disable-sync "
    "--disable-background-networking --disable-component-update"
)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working folder of the test, which is empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def browser():
    """A headless Chromium, where there is one."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    driver = shutil.which("chromedriver")
    if not (chromium and driver):
        pytest.skip("there is no chromium with its driver")
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in CHROMIUM:
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    session = webdriver.Chrome(options, Service(driver))
    yield session
    session.quit()


@pytest.fixture(scope="session")
def copy(tmp_path_factory):
    """A copy of the sources in an empty folder."""
    folder = tmp_path_factory.mktemp("clone")
    for name in ("dem", "rules", "config", "profiles", "studies"):
        shutil.copytree(
            ROOT / name,
            folder / name,
            ignore=shutil.ignore_patterns("__pycache__", "tests"),
        )
    (folder / "docs/explanation").mkdir(parents=True)
    for name in ("Snakefile", "docs/explanation/open.md"):
        shutil.copy(ROOT / name, folder / name)
    return folder


@pytest.fixture(scope="session")
def checkout(copy, tmp_path_factory):
    """The copy after one run of the smoke sweep, which the first process to ask makes for all."""
    if sys.platform == "win32":
        pytest.skip("the workflow needs POSIX")
    root = tmp_path_factory.getbasetemp()
    root = root.parent if "PYTEST_XDIST_WORKER" in os.environ else root
    shared, making = root / "checkout", root / "making"
    with FileLock(root / "checkout.lock"):
        if not shared.exists():
            completed(shutil.copytree(copy, making, dirs_exist_ok=True), "-j2")
            making.rename(shared)
    return shutil.copytree(shared, tmp_path_factory.mktemp("run") / "copy", symlinks=True)


@pytest.fixture(scope="session")
def checkout_with_claims(checkout):
    """The same after the study of claims too, whose runs `dem sweep` makes, in fewer processes."""
    if not (checkout / "studies/claims").is_dir():
        pytest.skip("needs the study claims")
    words = "-m", "dem", "sweep", "studies/claims/smoke.yaml", "-j2"
    run(*words, cwd=checkout, path=[checkout])
    completed(checkout, "claims", "-j2")
    return checkout
