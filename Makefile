# make poisson   set up if needed, run the main study; results in reports/latest
# make test      set up if needed, run the tests
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RUN := $(BIN)/python -m msvalidate.study

.PHONY: help poisson bench cases check any-cpu docs report test floors slow mutants simulators lint types format clean

help:
	@sed -n 's/^# make/make/p' Makefile

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "make: $(PYTHON) is older than Python 3.11; try: make $(MAKECMDGOALS) PYTHON=python3.12" >&2; exit 2; }
	$(PYTHON) -m venv $(VENV)

# What is needed to run studies, and what is needed to work on them. Either is made again when
# pyproject.toml changes.
$(VENV)/runs: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable .
	@touch $@

$(VENV)/develops: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable '.[dev]'
	@touch $@ $(VENV)/runs

$(VENV)/peers: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable '.[peers,fast]'
	@touch $@ $(VENV)/runs

poisson: $(VENV)/runs
	@$(RUN) poisson claims

# make check     every study in its small form against theory, bands and the committed baseline
check: $(VENV)/runs
	$(RUN) check $(ARGS)

# make any-cpu   the same as three other processors would run it; ARGS="--as old" for one of them
any-cpu: $(VENV)/runs
	$(BIN)/python .ci/any_cpu.py $(ARGS)

# make bench     time springs and elements beside their peers, and tell what was aimed at
bench: $(VENV)/peers
	OMP_NUM_THREADS=1 $(RUN) cost --table machine --table targets $(ARGS)

# make report    report.html again, from the results in reports/latest
report: $(VENV)/runs
	$(RUN) report

# As many workers as cores, so a thread each.
test: $(VENV)/develops
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder -m "not slow" $(ARGS)

# make docs     the documentation site, in build/docs/index.html
$(VENV)/documents: pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --editable '.[docs]'
	@touch $@ $(VENV)/runs

docs: $(VENV)/documents
	MPLBACKEND=Agg $(BIN)/python -m sphinx --quiet -W --keep-going -b html docs build/docs

# make floors    the tests with the oldest versions that pyproject.toml allows (PYTHON=python3.11)
OLDEST := import re, tomllib; \
  project = tomllib.load(open("pyproject.toml", "rb"))["project"]; \
  print(*(re.sub(">=([^,]*).*", r"==\1", each) for each in project["dependencies"]), sep="\n")
floors:
	$(PYTHON) -m venv --clear .venv-floors
	.venv-floors/bin/python -c '$(OLDEST)' > .venv-floors/oldest.txt
	PIP_CONSTRAINT=.venv-floors/oldest.txt $(MAKE) test VENV=.venv-floors

# make slow      the tests that take minutes: nightly, not at each change
slow: $(VENV)/develops
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto -m slow $(ARGS)

# make cases     the frozen set of cases, from nothing: an hour; a version that is there is never
#                written again
cases: $(VENV)/peers
	@$(BIN)/python -m cases.make ready
	OMP_NUM_THREADS=1 $(BIN)/python -m cases.make solve
	OMP_NUM_THREADS=1 $(BIN)/python -m cases.make peer
	OMP_NUM_THREADS=1 $(BIN)/python -m cases.make freeze

# make mutants   small faults put in one at a time: which do the tests miss? nightly
mutants: $(VENV)/develops
	OMP_NUM_THREADS=1 $(BIN)/python tests/mutation/run.py $(ARGS)

# make simulators  an environment .venv-NAME for each of simulators/requirements/NAME.txt, as pinned
simulators: $(patsubst simulators/requirements/%.txt,.venv-%/ready,$(wildcard simulators/requirements/*.txt))

.venv-%/ready: simulators/requirements/%.txt
	$(PYTHON) -m venv --clear .venv-$*
	.venv-$*/bin/python -m pip install --quiet --require-hashes --requirement $<
	@touch $@

# make lint      style, make types: types, make format: rewrite to style
lint: $(VENV)/develops
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/develops
	$(BIN)/mypy

format: $(VENV)/develops
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

# make clean     remove the environment and what was built, compiled kernels among it
clean:
	rm -rf $(VENV) .venv-* build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis reports/latest
	find msvalidate reference_fem studies tests -name __pycache__ -prune -exec rm -rf {} +
