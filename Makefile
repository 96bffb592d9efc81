# make: set up and run the paper.  make test: the test suite.  make docs: the documentation.
PYTHON ?= python3
ACTIVATE = . .venv/bin/activate
INSTALL = @$(ACTIVATE) && python setup/install.py
# uv and pip by the pip of that Python, where it has one: to unpack its own copy takes ensurepip five seconds.
FETCH = $(PYTHON) -m pip --python .venv/bin/python -qq install --no-compile --require-hashes -r setup/requirements.txt
# Empty, so that Python keeps bytecode: else each of many processes compiles the package anew, in half a second.
export PYTHONDONTWRITEBYTECODE :=
# Bytecode of what the workflow imports, two processes; of all packages it would take three times as long.
WARM = python -c "import dem.cli.app, numba, snakemake.cli; numba.njit(lambda: 0)()" & \
	python -c "import matplotlib.pyplot, netCDF4, scipy.stats, xarray" & wait

.PHONY: paper test docs locks
paper: .venv/ready
	$(ACTIVATE) && snakemake -j2
	@echo "Done: results/drag.nc and results/figures. Next: . .venv/bin/activate; dem info results/drag.nc"

test: .venv/test
	$(ACTIVATE) && pytest

docs: .venv/docs
	$(ACTIVATE) && sphinx-build --fail-on-warning --keep-going --quiet docs docs/_build/html
	@echo "open docs/_build/html/index.html"

.venv/ready: requirements.txt setup/requirements.txt pyproject.toml
	@$(PYTHON) -c "import sys; sys.exit('Python 3.11 or newer is needed: make PYTHON=...' if sys.version_info < (3, 11) else 0)"
	@echo "Making .venv"
	@$(PYTHON) -m venv --clear --without-pip .venv
	@$(FETCH) 2> /dev/null || .venv/bin/python -m ensurepip > /dev/null
	$(INSTALL) requirements.txt
	$(INSTALL) --editable .
	@echo "Compiling what the workflow imports"
	@$(ACTIVATE); $(WARM)
	@touch .venv/ready

.venv/test: .venv/ready tests/requirements.txt
	$(INSTALL) tests/requirements.txt
	@touch .venv/test

.venv/docs: .venv/ready docs/requirements.txt
	$(INSTALL) docs/requirements.txt
	@touch .venv/docs

# The locks, with hashes for all systems. uv keeps the versions of a lock that is there.
# It is in .venv once `make` has run.
COMPILE = .venv/bin/uv pip compile --quiet --universal --generate-hashes --no-cache \
	--no-emit-index-url --no-emit-find-links --no-header --no-annotate --python-version 3.11
PACKAGE = pyproject.toml --extra build --extra design
locks:
	printf 'pip\nuv\n' | $(COMPILE) -o setup/requirements.txt -
	$(COMPILE) $(PACKAGE) -o requirements.txt
	$(COMPILE) $(PACKAGE) --constraint requirements.txt --extra test -o tests/requirements.txt
	$(COMPILE) $(PACKAGE) --constraint requirements.txt --extra docs -o docs/requirements.txt
