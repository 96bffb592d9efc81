# make: set up and run the paper.  make test: the test suite.  make docs: the documentation.
PYTHON ?= python3
ACTIVATE = . .venv/bin/activate
INSTALL = $(ACTIVATE) && pip install --disable-pip-version-check --quiet

.PHONY: paper test docs locks
paper: .venv/ready
	$(ACTIVATE) && snakemake -j2
	@echo "Done: results/drag.nc and results/figures. Next: . .venv/bin/activate; dem info results/drag.nc"

test: .venv/test
	$(ACTIVATE) && pytest

docs: .venv/docs
	$(ACTIVATE) && sphinx-build --fail-on-warning --keep-going --quiet docs docs/_build/html
	@echo "open docs/_build/html/index.html"

.venv/ready: requirements.txt pyproject.toml
	$(PYTHON) -c "import sys; sys.exit('Python 3.11 or newer is needed: make PYTHON=...' if sys.version_info < (3, 11) else 0)"
	$(PYTHON) -m venv --clear .venv
	$(INSTALL) --require-hashes -r requirements.txt
	$(INSTALL) --no-deps --no-build-isolation --editable .
	touch .venv/ready

.venv/test: .venv/ready tests/requirements.txt
	$(INSTALL) --require-hashes -r tests/requirements.txt
	touch .venv/test

.venv/docs: .venv/ready docs/requirements.txt
	$(INSTALL) --require-hashes -r docs/requirements.txt
	touch .venv/docs

# The locks, with hashes for all systems. uv keeps the versions of a lock that is there.
COMPILE = uv pip compile --quiet --universal --generate-hashes --no-cache --no-emit-index-url \
	--no-emit-find-links --no-header --no-annotate --python-version 3.11 --extra build pyproject.toml
locks:
	$(COMPILE) -o requirements.txt
	$(COMPILE) --constraint requirements.txt --extra test -o tests/requirements.txt
	$(COMPILE) --constraint requirements.txt --extra docs -o docs/requirements.txt
