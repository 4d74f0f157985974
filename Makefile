# A fresh machine needs Python >= 3.11 and make; everything else is installed into .venv.
PYTHON ?= python3
BIN := .venv/bin
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: help demo test lint acceptance tutorials uses extending bench soak fleet clean

help:
	@echo "make demo        fly the bundled An-26 approach and write its report"
	@echo "make test        lint and run the tests"
	@echo "make acceptance  measure every required figure at full size"
	@echo "make tutorials   run the tutorials and renew what they print and draw"
	@echo "make uses        run what README and docs show and renew transcripts and figures"
	@echo "make extending   renew the files that docs/extending.md quotes"
	@echo "make fleet       fly every stock aircraft of JSBSim and renew the table of list --aircraft"
	@echo "                 with ROOT=DIR fly every aircraft of a folder of others into out/fleet.toml"
	@echo "make bench       measure speed, as ratios within one run"
	@echo "make soak        kill workers and parents of studies and compare what is left"

.venv/ready: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "shortfinal needs Python 3.11 or newer")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

demo: .venv/ready
	$(BIN)/shortfinal run an26_pattern -o out/an26_pattern

test: .venv/ready lint
	$(BIN)/python -m pytest -n 2 -m "not acceptance"

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

acceptance: .venv/ready
	ANEW=1 $(BIN)/python -m pytest -m acceptance -s tests/acceptance

tutorials: .venv/ready
	$(BIN)/python tests/docs/tutorials.py

uses: .venv/ready
	$(BIN)/python tests/docs/uses.py

extending: .venv/ready
	$(BIN)/python tests/docs/extending.py

fleet: .venv/ready
	$(BIN)/python -m sim.cli.fleet $(if $(ROOT),--root '$(ROOT)')

bench: .venv/ready
	$(BIN)/python tests/benchmarks/run.py

soak: .venv/ready
	$(BIN)/python -m tests.soak.soak

clean:
	rm -rf .venv out build dist
