# Two commands on a fresh machine: `make run` and `make test`.
# Each target sets up what it needs; nothing has to be installed by hand first.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
CONFIG ?= configs/simulation.yaml

.PHONY: help install install-dev run test coverage lint types arrows check wheel clean
.PHONY: firmware hil arena-pc fuzz rtsp faults adversary bench house paper pictures browser docs examples
.DEFAULT_GOAL := help

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-14s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "clearway needs Python 3.11 or newer; $(PYTHON) is $$($(PYTHON) --version 2>&1). Set PYTHON=..." >&2; exit 2; }
	@$(PYTHON) -m venv $(VENV) || \
	  { rm -rf $(VENV); echo "$(PYTHON) cannot make a virtual environment; on Debian: apt-get install python3-venv" >&2; exit 2; }

# pip would compile all Python files on one core: 10 of the 20 s that it takes. A package may ship
# files for another version of Python: they stay as they are, as with pip.
PIP_INSTALL = $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --editable
COMPILE_PYTHON = @$(BIN)/python -m compileall -qq --workers 0 $(VENV)/lib || true

$(VENV)/.installed: pyproject.toml | $(BIN)/python
	$(PIP_INSTALL) .
	$(COMPILE_PYTHON)
	@touch $@

$(VENV)/.installed-dev: pyproject.toml | $(BIN)/python
	$(PIP_INSTALL) '.[dev]'
	$(COMPILE_PYTHON)
	@touch $@ $(VENV)/.installed

# Compiled once, in two processes: each worker of the tests would compile its own.
KERNELS = $(shell grep -rlE "njit" vision planner --include='*.py')
$(VENV)/.kernels: $(VENV)/.installed-dev $(KERNELS)
	@echo "compiling the kernels that are missing"
	@$(BIN)/python -m navigation.run.kernels.rehearsal
	@touch $@

install: $(VENV)/.installed ## make .venv with .venv/bin/clearway

install-dev: $(VENV)/.installed-dev ## the same with the tools for developers

run: $(VENV)/.installed ## the whole loop on a simulated arena
	$(BIN)/clearway run $(CONFIG) --once

# A worker takes one file of tests after the other, slow ones first; there is one worker more than
# cores, as many tests wait for a child; none of them starts threads of its own, which would only wait
# for a core that another worker has. What says how long something may take, and what drives an
# emulated processor, comes after all others, two at a time, since most of it only waits. Nothing is
# run twice.
WORKERS ?= $(shell expr $$(nproc) + 1)
TIMED_WORKERS ?= 2
TIMED = $(shell grep -rlE "mark\.timed" tests --include='test_*.py')
test: $(VENV)/.kernels ## every test
	OPENBLAS_NUM_THREADS=1 OPENCV_FOR_THREADS_NUM=1 $(BIN)/python -m pytest --numprocesses $(WORKERS) \
	  --dist loadfile --no-loadscope-reorder -m "not timed"
	$(BIN)/python -m pytest --numprocesses $(TIMED_WORKERS) --maxschedchunk 1 -m timed $(TIMED)

coverage: $(VENV)/.installed-dev ## the tests, with the lines that they never reach
	$(BIN)/python -m pytest --cov --cov-report=term-missing

firmware: $(VENV)/.installed-dev ## build and test the C99 robot: Linux process, twin, boards
	bash .ci/packages firmware
	bash .ci/micropython
	$(MAKE) -C firmware_protocol/firmware host twin replay avr cortex-m arduino arduino-core
	$(BIN)/python -m pytest tests/firmware_protocol tests/hil

hil: $(VENV)/.installed-dev ## the binaries on an emulated ATmega328P and Cortex-M3
	bash .ci/packages firmware
	bash .ci/micropython
	$(BIN)/python -m pytest tests/hil

arena-pc: $(VENV)/.installed-dev ## Debian on an emulated PC: real drivers, udev, systemd; root only
	bash .ci/arena-pc

FUZZ_S ?= 600
fuzz: $(VENV)/.installed-dev ## libFuzzer on the firmware's parser and the whole robot, FUZZ_S each
	bash .ci/packages firmware fuzz
	$(MAKE) -C firmware_protocol/firmware fuzz
	for one in link robot; do \
	  $(BIN)/python -m tests.support.wire.corpus unpack $$one build/corpus/$$one && \
	  build/firmware/fuzz_$$one -max_len=2000 -max_total_time=$(FUZZ_S) -print_final_stats=1 \
	    build/corpus/$$one || exit 1; done

rtsp: $(VENV)/.installed-dev ## a real RTSP server that stalls, freezes and dies, two minutes
	bash .ci/packages rtsp
	OPENCV_LOG_LEVEL=SILENT OPENCV_FFMPEG_LOGLEVEL=-8 $(BIN)/python -m tests.hil.rtsp

faults: $(VENV)/.installed-dev ## the serial link's fault matrix, into benchmarks/results/faults.md
	bash .ci/packages firmware
	$(BIN)/python -m benchmarks.faults

adversary: $(VENV)/.installed-dev ## attacks on the running system, into benchmarks/results/adversary.md
	$(BIN)/python -m benchmarks.adversary

paper: $(VENV)/.installed-dev ## the paper's figures and tables, into docs/paper/
	$(BIN)/python -m benchmarks.paper

house: $(VENV)/.installed-dev ## the code's figures, and the picture of the folders
	$(BIN)/python -m benchmarks.house --graph docs/pictures/folders.svg
	$(BIN)/python -m benchmarks.house --list

pictures: $(VENV)/.installed-dev ## the documentation's pictures, into docs/pictures/
	$(BIN)/python -m benchmarks.house --graph docs/pictures/folders.svg
	bash .ci/packages browser
	$(BIN)/python -m benchmarks.figures
	$(BIN)/python -m benchmarks.figures.film
	$(BIN)/python -m tests.browser.pictures

docs: $(VENV)/.installed-dev ## the documentation site, strictly, into build/site
	NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet
	@echo "build/site/index.html; to search, serve it: $(BIN)/python -m http.server -d build/site"

examples: $(VENV)/.installed-dev ## run every example; their pictures into build/examples
	mkdir -p build/examples
	for one in examples/*.py; do echo "== $$one"; $(BIN)/python $$one build/examples || exit 1; done
	cp examples/*.ipynb build/examples
	cd build/examples && for one in *.ipynb; do echo "== $$one"; \
	  MPLBACKEND=agg $(abspath $(BIN))/jupyter execute --inplace $$one || exit 1; done

browser: $(VENV)/.installed-dev ## the dashboard in a real browser; screenshots in build/browser/
	bash .ci/packages browser
	CLEARWAY_SCREENSHOTS=1 $(BIN)/python -m pytest tests/browser

# adversary, paper and figures have targets of their own; house and same_runs measure no time
BENCHES = $(filter-out __init__ adversary paper house figures same_runs,$(sort \
  $(patsubst benchmarks/%.py,%,$(wildcard benchmarks/*.py)) \
  $(patsubst benchmarks/%/__main__.py,%,$(wildcard benchmarks/*/__main__.py))))
bench: $(VENV)/.installed-dev ## every benchmark, into benchmarks/results/
	for one in $(BENCHES); do echo "== $$one"; $(BIN)/python -m "benchmarks.$$one" || exit 1; done

lint: $(VENV)/.installed-dev ## ruff: style and format
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.installed-dev ## mypy --strict
	$(BIN)/mypy

arrows: $(VENV)/.installed-dev ## import-linter: imports run downwards only
	$(BIN)/lint-imports

check: lint types arrows test ## everything a change has to pass

PROCESSORS ?= $(if $(filter aarch64,$(shell uname -m)),generic,x86-64-v3 x86-64-v2)
wheel: $(VENV)/.installed-dev ## build the wheel into dist/, its kernels compiled for PROCESSORS
	rm -rf dist
	$(BIN)/python -m pip wheel --quiet --no-deps --wheel-dir dist .
	$(BIN)/python .ci/compile-wheel dist/*.whl $(PROCESSORS)

clean: ## remove what the other targets made
	rm -rf $(VENV) dist build runs .mypy_cache .ruff_cache .pytest_cache .hypothesis .coverage htmlcov
