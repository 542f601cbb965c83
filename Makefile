# Needs Python >= 3.11 with its venv module, git and make; nothing else has to be installed by hand.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PYTEST := $(BIN)/python -m pytest

# As the commands of wpcal do (wpcal/core/process.py): tests run beside one another, and threads would wait for one another.
export OMP_NUM_THREADS = 1
export OPENBLAS_NUM_THREADS = 1

.PHONY: demo test near check js other-pythons lowest attack same-answers deep bench docs fixtures viewer shots lint clean

demo: $(VENV)/ready ## run the main job on the sample part; writes out/
	rm -rf out
	$(BIN)/wpcal demo -o out

test: $(VENV)/ready ## the tests of a push, 8 to 9 minutes (CONTRIBUTING.md); in CI no test may be skipped for a new reason
	$(PYTEST) -n 2 --dist loadfile -m "not deep" --durations=30 $(if $(CI),--assert-skips)

near: $(VENV)/ready ## the tests that your change can reach, with lint and types: about a minute
	$(BIN)/python -m tests.near

check: lint js docs test ## what CI runs

lint: $(VENV)/ready
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python -m tests.lint.docstrings
	$(BIN)/python -m tests.lint.structure

js: ## format, lint and unit tests of the pages' JavaScript; skipped, and says so, without Node
	sh .ci/javascript

docs: $(VENV)/ready ## the pages and the reference as HTML in docs/_build; a warning is an error
	rm -rf docs/reference/library
	$(BIN)/sphinx-build -q -W --keep-going -b html docs docs/_build

other-pythons: ## the demo and a selection of tests on Python 3.13; in `make deep` on 3.12, too
	sh .ci/other-pythons

lowest: ## the commands at the lowest versions that pyproject.toml allows
	sh .ci/lowest

same-answers: $(VENV)/ready ## poses, plans and programs that must not depend on the processor
	$(PYTEST) tests/laws/test_same_pose.py tests/laws/test_same_plan.py tests/unit/controllers/test_how_to_pages.py

deep: $(VENV)/ready ## the tests that no push runs, breaks of the changed lines, and the README's commands on a bare Debian
	$(PYTEST) -n 2 --dist loadfile -m deep --durations=30
	sh .ci/other-pythons --deep
	sh .ci/lowest --deep
	$(BIN)/python -m tests.mutate
	$(BIN)/python -m tests.attack
	sh .ci/bare

attack: $(VENV)/ready ## kills, signals, full and read-only disks and two writers against a calibration and the picker; some minutes
	$(BIN)/python -m tests.attack

.PHONY: fuzz
fuzz: $(VENV)/ready ## wrong input for every reader, SECONDS=600 in all; findings go to tests/fuzz/findings and are tested
	$(BIN)/python -m tests.fuzz --seconds $(or $(SECONDS),600)
	$(BIN)/python -m tests.fuzz.kernel --inputs $(or $(FILES),300)
	$(BIN)/python -m tests.fuzz.chain --inputs $(or $(FILES),300)

bench: $(VENV)/ready ## ratios against named peers, measured in this run
	$(BIN)/python -m tests.benchmarks

fixtures: $(VENV)/ready ## write fixtures/ anew (golden results only with tests/golden --regenerate), and the files in docs/how-to
	$(BIN)/python -m cad.samples.parts fixtures
	$(BIN)/python -m tests.samples.uprights fixtures/uprights
	$(BIN)/python -m tests.samples.graphs fixtures/graphs
	$(BIN)/python docs/make_controller_files.py

viewer: ## build the pages' JavaScript anew; needs Node
	test ! -L wpcal/pages/source/node_modules || { echo "node_modules is a link: npm ci would empty its target"; exit 1; }
	cd wpcal/pages/source && npm ci --ignore-scripts --no-audit --no-fund && node build.mjs

.PHONY: freecad-addon
freecad-addon: ## build dist/wpcal-workbench.zip, which is unpacked into FreeCAD's folder Mod
	$(PYTHON) -m cad.freecad.build dist/wpcal-workbench.zip

.PHONY: release
release: $(VENV)/ready ## build what is published into dist/, try it, and say which commands publish it
	sh .ci/release

shots: $(VENV)/ready ## photograph the pages and the FreeCAD workbench for docs/; needs chromium and FreeCAD
	sh .ci/browser
	sh .ci/freecad
	$(BIN)/python docs/make_shots.py
	$(BIN)/python docs/make_freecad_shots.py

# The kernel's wheel needs the system's libGL: looked for before anything is downloaded.
$(VENV)/ready: pyproject.toml .ci/system-libraries
	sh .ci/system-libraries
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check --editable ".[dev]"
	touch $@

clean:
	rm -rf $(VENV) out docs/_build .mypy_cache .ruff_cache .pytest_cache .hypothesis
