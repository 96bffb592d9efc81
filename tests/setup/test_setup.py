"""The set-up: uv looks where pip would look, and pip takes its place."""

import importlib.metadata
import os
import re
import runpy
import subprocess
import sys

import pytest
from project import ROOT

SCRIPT = ROOT / "setup" / "install.py"


def test_uv_looks_where_pip_looks(tmp_path, monkeypatch):
    """The environment overrides the section of `install`, which overrides the global one."""
    install = runpy.run_path(str(SCRIPT))
    configuration = tmp_path / "pip.conf"
    configuration.write_text(
        "[global]\nindex-url = https://a.example/simple\nfind-links = /one\n  /two\ntimeout = 7\n"
        "[install]\nextra-index-url = https://b.example/simple\n  https://c.example/simple\n"
        "timeout = 9\n"
    )
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", str(configuration))
    monkeypatch.setenv("PIP_INDEX_URL", "https://d.example/simple")
    monkeypatch.setenv("PIP_CERT", "/own.pem")
    user = {"UV_SYSTEM_CERTS": "false"}  # what the user tells uv remains
    environment = install["uv_environment"](install["pip_settings"](), user)
    expected = {
        "UV_DEFAULT_INDEX": "https://d.example/simple",
        "UV_INDEX": "https://b.example/simple https://c.example/simple",
        "UV_FIND_LINKS": "/one,/two",
        "UV_HTTP_TIMEOUT": "9",
        "SSL_CERT_FILE": "/own.pem",
    }
    assert (expected | user).items() <= environment.items()


def test_pip_installs_if_uv_fails(tmp_path):
    """Without a network: the lock is empty, and uv can neither be fetched nor read its options."""
    lock = tmp_path / "an empty lock.txt"
    lock.write_text("")
    broken = {"PIP_NO_INDEX": "1", "PIP_FIND_LINKS": "", "UV_INDEX_STRATEGY": "none such"}
    process = subprocess.run(
        [sys.executable, SCRIPT, lock], env=os.environ | broken, capture_output=True, text=True
    )
    assert process.returncode == 0, process.stderr
    assert "pip installs the same versions" in process.stdout


def test_make_installs_all_that_its_targets_import():
    """Whatever `snakemake TARGET` imports is in the environment that `make` makes, before any run."""
    lock = (ROOT / "requirements.txt").read_text()
    locked = set(re.findall(r"^([A-Za-z0-9._-]+)==", lock, re.MULTILINE))
    files = [*ROOT.glob("dem/**/*.py"), *ROOT.glob("studies/**/*.py"), *ROOT.glob("rules/*.smk")]
    imported = set()
    for file in files:
        if "tests" not in file.parts:
            lines = re.findall(r"^ *(?:from|import) ([A-Za-z_]\w*)", file.read_text(), re.MULTILINE)
            imported.update(lines)
    packages = importlib.metadata.packages_distributions()
    names = {name for module in imported & packages.keys() for name in packages[module]}
    missing = {name for name in names if re.sub(r"[-_.]+", "-", name).lower() not in locked}
    # of who names a scheduler, and a code that the benchmark leaves out where it is not installed
    assert missing <= {"granular-drag", "distributed", "lammps"}


@pytest.mark.parametrize("folder", ["", "setup", "tests", "docs"])
def test_a_lock_names_no_address_and_hashes_every_package(folder):
    text = (ROOT / folder / "requirements.txt").read_text()
    assert "://" not in text and "--index" not in text
    packages = text.replace("\\\n", " ").splitlines()
    assert packages and all("--hash=sha256:" in package for package in packages)
