# Each of these does its own set-up: a virtual environment in .venv with this package and what it needs.
.PHONY: run test test-all check bench paper studies gallery torture fuzz powerloss kills wheel clean

PYTHON ?= python3
ifeq ($(OS),Windows_NT)
BIN := .venv/Scripts
else
BIN := .venv/bin
endif
READY := .venv/.ready
DEVELOP := .venv/.develop

run: $(READY)
	@mkdir -p results
	$(BIN)/cosim run lrt-curve --set vehicle.speed=8 --gyro nonlinear --set gyro.rotor_speed=2000rpm --record-every 10 --output results/lrt-curve.csv
	@$(BIN)/cosim run lrt-curve --set vehicle.speed=8 --gyro off --record-every 10 --output results/lrt-curve-off.csv > results/lrt-curve-off.txt || [ $$? = 1 ]
	@$(BIN)/cosim plot results/lrt-curve.csv results/lrt-curve-off.csv --label "gyro units at 2000 rpm" --label "gyro units off" -o results/lrt-curve.png

test: $(DEVELOP)
	$(BIN)/python -m pytest -q -n 2 --dist loadfile

test-all: $(DEVELOP)
	$(BIN)/python -m pytest -q -n 2 --dist loadfile -m "slow or not slow"

check: $(DEVELOP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/python .ci/tree.py mypy
	$(BIN)/python .ci/tree.py lint-imports

# Some minutes. Apart, since they take longer: benchmarks/same_bits.py, mathematics.py, and `cosim paper --draws`.
bench: $(DEVELOP)
	$(BIN)/python benchmarks/run.py
	$(BIN)/python benchmarks/vehicle_speed.py
	$(BIN)/python benchmarks/lanes.py
	$(BIN)/python benchmarks/scale.py
	$(BIN)/python benchmarks/long.py
	$(BIN)/python benchmarks/peers.py

# Hostile FMUs, some minutes; see docs/reliability.md.
torture: $(DEVELOP)
	PYTHONPATH=tests/support $(BIN)/python campaigns/torture.py

# Mutated input at every door, some minutes; see docs/reliability.md.
fuzz: $(DEVELOP)
	$(BIN)/python campaigns/fuzz.py --inputs 6500
	$(BIN)/python campaigns/faces.py

# Loss of power at every call that changes a file, some 20 minutes; see docs/reliability.md.
powerloss: $(DEVELOP)
	$(BIN)/python campaigns/powerloss.py

# 300 kill -9 at random instants, some half an hour; see docs/reliability.md.
kills: $(DEVELOP)
	$(BIN)/python campaigns/kills.py

paper: $(READY)
	$(BIN)/cosim paper

studies: $(READY)
	$(BIN)/python studies

gallery: $(READY)
	$(BIN)/python docs/gallery.py

# A wheel that holds the page of a report ready made, so that whoever installs it needs no Node.js. Needs the npm registry.
wheel: $(DEVELOP)
	rm -rf src/cosim/report/page/built
	$(BIN)/python -c "from gyro_cosim.report.bundling import BUILT, build; build(BUILT)"
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .
	rm -rf src/cosim/report/page/built

clean:
	rm -rf .venv results dist

# Debian without python3-venv can still make an environment through virtualenv, where that is installed.
$(READY): pyproject.toml setup.py
	test -x $(BIN)/python || $(PYTHON) -m venv .venv || $(PYTHON) -m virtualenv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(DEVELOP): pyproject.toml $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .[dev]
	@touch $@
