# A fresh machine needs Python >= 3.11 and make; everything else is installed into .venv.
PYTHON ?= python3
BIN := .venv/bin
export OPENBLAS_NUM_THREADS := 1
export OMP_NUM_THREADS := 1

.PHONY: help demo test test-oldest lint acceptance docs gallery tutorials uses extending densities bench soak fleet clean

help:
	@echo "make demo        fly the bundled An-26 approach and write its report"
	@echo "make test        lint and run the tests"
	@echo "make test-oldest  the same in part, with the lowest versions that pyproject.toml allows"
	@echo "make acceptance  measure every required figure at full size"
	@echo "make docs        build the documents as a site into out/docs, notebooks of the tutorials too"
	@echo "make gallery     fly every bundled scenario and renew the pictures of docs/gallery.md"
	@echo "make tutorials   run the tutorials and renew what they print and draw"
	@echo "make uses        run what README and docs show and renew transcripts and figures"
	@echo "make extending   renew the files that docs/extending.md quotes"
	@echo "make densities   search the process noise of every tracker, renew docs/densities.md and arrival-densities.md"
	@echo "make fleet       fly every stock aircraft of JSBSim and renew the table of list --aircraft"
	@echo "                 with ROOT=DIR fly every aircraft of a folder of others into out/fleet.toml"
	@echo "make bench       measure speed, as ratios within one run"
	@echo "make soak        run every case that make test only samples; kill workers and parents of studies,"
	@echo "                 interrupt all commands, compare what is left"

.venv/ready: pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "shortfinal needs Python 3.11 or newer")'
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev]'
	touch $@

demo: .venv/ready
	$(BIN)/shortfinal run an26_pattern -o out/an26_pattern

test: .venv/ready lint
	$(BIN)/python -m pytest -n 2 --dist worksteal -m "not acceptance and not soak"

# A file of each package and of each library that is held down; old libraries may warn about newer ones of others.
OLDEST := build/oldest
OLDEST_TESTS := tests/tracking/test_gaussian.py tests/tracking/test_track.py tests/tracking/test_imm.py \
	tests/tracking/test_filterpy_agreement.py tests/tracking/test_damaged_records.py \
	tests/autopilot/test_disk_margin.py tests/autopilot/test_laws.py \
	tests/autopilot/test_route_law_against_control_theory.py tests/aircraft/test_air.py \
	tests/aircraft/test_against_newton.py tests/sim/scenario/test_units.py \
	tests/sim/metrics/test_checks_against_rtamt.py tests/sim/metrics/test_verdict.py \
	tests/sim/workers/test_blas.py tests/sim/reporting/test_report_trackers.py \
	tests/sim/reporting/test_drawing.py

$(OLDEST)/ready: pyproject.toml tests/oldest.py
	$(PYTHON) -m venv $(OLDEST)
	$(PYTHON) tests/oldest.py > $(OLDEST)/constraints.txt
	$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check \
		--constraint $(OLDEST)/constraints.txt --editable '.[dev]'
	touch $@

test-oldest: $(OLDEST)/ready
	$(OLDEST)/bin/python -m pytest -W ignore::DeprecationWarning $(OLDEST_TESTS)
	$(OLDEST)/bin/shortfinal run --help
	$(OLDEST)/bin/shortfinal run an26_pattern -o $(OLDEST)/an26_pattern

lint: .venv/ready
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

acceptance: .venv/docs-ready
	ANEW=1 $(BIN)/python -m pytest -m acceptance -s tests/acceptance

.venv/docs-ready: .venv/ready
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[docs]'
	touch $@

docs: .venv/docs-ready
	$(BIN)/python -m tests.docs.site.assemble
	$(BIN)/zensical build --clean --strict
	@echo $(CURDIR)/out/docs/index.html

gallery: .venv/ready
	$(BIN)/python -m tests.docs.site.gallery

tutorials: .venv/ready
	$(BIN)/python tests/docs/tutorials.py

uses: .venv/ready
	$(BIN)/python tests/docs/uses.py

extending: .venv/ready
	$(BIN)/python tests/docs/extending.py

densities: .venv/ready
	$(BIN)/python tests/tuning/densities.py
	$(BIN)/python -m tests.tuning.arrival_densities

fleet: .venv/ready
	$(BIN)/python -m sim.cli.fleet $(if $(ROOT),--root '$(ROOT)')

bench: .venv/ready
	$(BIN)/python tests/benchmarks/run.py

soak: .venv/ready
	$(BIN)/python -m pytest -n 2 --dist worksteal -m soak
	$(BIN)/python -m tests.soak.soak
	$(BIN)/python -m tests.soak.interrupts

clean:
	rm -rf .venv out build dist
