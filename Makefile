# make: set up and run the paper.  make test: set up and run the test suite.
PYTHON ?= python3
ACTIVATE = . .venv/bin/activate

.PHONY: paper test
paper: .venv/ready
	$(ACTIVATE) && snakemake -j2

test: .venv/ready
	$(ACTIVATE) && pytest

.venv/ready: requirements.txt pyproject.toml
	$(PYTHON) -c "import sys; sys.exit('Python 3.11 or newer is needed: make PYTHON=...' if sys.version_info < (3, 11) else 0)"
	$(PYTHON) -m venv --clear .venv
	$(ACTIVATE) && pip install --disable-pip-version-check --quiet --require-hashes -r requirements.txt
	$(ACTIVATE) && pip install --disable-pip-version-check --quiet --no-deps --no-build-isolation --editable .
	touch .venv/ready
