# Everything that make does stays inside this checkout: packages in .venv, every cache and temporary file in .cache, results in out.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
.NOTPARALLEL:
.PHONY: help help-all run test quick lint types contracts sizes checks pytest contract slow nightly fresh lowest bench stress numbers regress cases publish maps peers examples docs pages constraints pins clean distclean

PY := .venv/bin/python
PROGRAM := .venv/.installed
STAMP := .venv/.installed-for-tests
PEERS_STAMP := .peers/.installed
PYTEST_ARGS ?=
SPHINX ?=
# The Pythons that all pins have wheels for, as pyproject.toml names them. PYTHON=python3.13 takes that one, otherwise python3 is tried first.
PYTHONS := $(shell sed -n 's/.*"Programming Language :: Python :: \(3\.[0-9]*\)".*/\1/p' pyproject.toml)
PYTHON ?=

export XDG_CACHE_HOME := $(CURDIR)/.cache
export XDG_DATA_HOME := $(CURDIR)/.cache/data
export PIP_CACHE_DIR := $(CURDIR)/.cache/pip
export MPLCONFIGDIR := $(CURDIR)/.cache/matplotlib
export PYVISTA_USERDATA_PATH := $(CURDIR)/.cache/pyvista
export HYPOTHESIS_STORAGE_DIRECTORY := $(CURDIR)/.cache/hypothesis
export TMPDIR := $(CURDIR)/.cache/tmp
export MPLBACKEND := Agg
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# One thread for each process: pytest runs one process on each core already, and threads of BLAS or OpenMP on top of that only
# fight for the same cores (and make the last digits of a sum depend on who won).
ONE_THREAD := OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
# gmsh writes the preferences of its window toolkit into the home folder even when no window is opened. Only for our own
# programs: pip keeps the real home, where a user may have set it up.
HOME_HERE := HOME="$(CURDIR)/.cache/home"
# Modules are compiled once, for every program and test that starts another Python, even where the environment forbids that.
HOME_HERE += PYTHONPYCACHEPREFIX="$(CURDIR)/.cache/compiled" PYTHONDONTWRITEBYTECODE=

UV := .venv/bin/uv pip compile --quiet --no-header --only-binary :all:

# What `make test` and the tools need beside the program.
EXTRAS := test,lint,docs,parquet,cluster,browser
# Debian packages of other people's codes; one that is added here is installed by `make peers`.
PEERS := calculix-ccx python3-getfem

help: ## show this list
	@awk -F ':.* ## ' '/^[a-z-]+:.* ## / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

help-all: ## show every target
	@awk -F ':.* ##+ ' '/^[a-z-]+:.* ##+ / {printf "  make %-12s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

run: $(PROGRAM) ## the main job: the paper's Hertz cycle through both engines, and the report
	@echo "==> halfplane run hertz-paper"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(PY) -m reports run hertz-paper

test: lint contracts checks pytest ## everything that CI checks: lint, import contracts, types, the pages, tests

checks: $(STAMP) # types and pages take one core each: side by side
	@$(MAKE) --no-print-directory types & types=$$!; \
	pages=0; $(MAKE) --no-print-directory docs SPHINX="-t check" || pages=$$?; \
	wait $$types; exit $$pages

lint: $(STAMP) ### ruff: rules and format
	@echo "==> lint: ruff check"
	@$(PY) -m ruff check .
	@echo "==> lint: ruff format --check"
	@$(PY) -m ruff format --check .

types: $(STAMP) ### mypy over the five packages; of the programs beside them, the names that they read
	@echo "==> types: mypy"
	@$(PY) -m mypy
	@echo "==> types: names that benchmarks and docs read"
	@MYPYPATH=benchmarks:docs $(PY) -m mypy --explicit-package-bases benchmarks docs > .cache/names.txt || test $$? -le 1
	@! grep -E "\[attr-defined\]|Unexpected keyword argument" .cache/names.txt

contracts: $(STAMP) ### import-linter: who may import whom
	@echo "==> contracts: import-linter"
	@.venv/bin/lint-imports --no-logo --cache-dir .cache/import-linter

sizes: $(STAMP) ### statements and public names of each package
	@$(PY) benchmarks/sizes.py

pytest: $(STAMP) ### tests and doctests, slow ones skipped (more options: PYTEST_ARGS="-k hertz")
	@echo "==> tests: pytest on 2 processes; the first to end takes from the other"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) -m pytest -n 2 --dist worksteal --benchmark-disable --durations=10 --basetemp=.cache/tmp/pytest $(PYTEST_ARGS)

quick: $(STAMP) ## a minute: the contract, then the tests of what differs from the last commit (or of the last commit)
	@mkdir -p "$$TMPDIR" .cache/home
	@changed=$$(git diff --name-only HEAD -- '*.py'); \
	[ -n "$$changed" ] || changed=$$(git diff --name-only HEAD~1 -- '*.py'); \
	tests=$$(for file in $$changed; do \
	    package=$${file%%/*}; module=$$(basename "$$file" .py); \
	    case $$package in tests) ls "$$file" 2>/dev/null | grep '/test_' || true;; *) git grep -lw "$$module" -- "tests/test_$${package}*.py" || true;; esac; \
	done | sort -u); \
	echo "==> quick: tests/contract" $$tests; \
	$(HOME_HERE) $(ONE_THREAD) $(PY) -m pytest -q -n 2 --benchmark-disable --within 45 --basetemp=.cache/tmp/pytest tests/contract $$tests

slow: $(STAMP) ## the tests marked slow, and only these
	@echo "==> slow tests: pytest on 2 processes"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) -m pytest -n 2 -m slow --benchmark-disable --durations=10 --basetemp=.cache/tmp/pytest $(PYTEST_ARGS)

contract: $(STAMP) ### the frozen values of both engines and of comparisons, all of them, and nothing else
	@echo "==> contract: pytest on 2 processes"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) -m pytest -n 2 --slow --benchmark-disable --basetemp=.cache/tmp/pytest tests/contract

nightly: $(STAMP) ### every test, slow ones too, CalculiX and dask there, none skipped; then make test on the oldest and newest Python (root)
	@SECONDS=0; trap 'echo "==> nightly: exit code $$? after $$((SECONDS / 60)) min"' EXIT; \
	$(MAKE) --no-print-directory peers lint types contracts docs; \
	$(MAKE) --no-print-directory pins; \
	CI=1 $(MAKE) --no-print-directory pytest PYTEST_ARGS="--slow --hypothesis-profile=local $(PYTEST_ARGS)"; \
	$(MAKE) --no-print-directory fresh SUITES="bookworm forky"

fresh: $(PROGRAM) ### the README's own blocks in bare roots of Debian (root; SUITES="bookworm trixie"; MIRROR=URL for another than apt's)
	@$(PY) benchmarks/fresh.py $(SUITES)

lowest: $(STAMP) ### the wheel with the lowest versions that pyproject.toml allows: built, installed apart from .venv, run outside
	@echo "==> lowest: an environment of its own in .cache/lowest"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) benchmarks/packages.py lowest .cache/lowest

bench: $(STAMP) ### error against time, peers, growth, start-up, into docs/performance (SECTIONS="peers start": those alone)
	@echo "==> benchmarks"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) benchmarks/performance.py $(SECTIONS)

stress: $(STAMP) ### both engines at the ends of what a scene may ask, into docs/stress.md
	@echo "==> stress"
	@$(ONE_THREAD) $(PY) benchmarks/stress.py

numbers: $(STAMP) ### measure every promised number, into docs/numbers.md (SECTIONS='"Finite*" Time': some of them)
	@echo "==> numbers"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) benchmarks/claims.py $(SECTIONS)

regress: RUNS := regress
regress: cases ### the quick part of make cases: half-plane theory at a few instants and places, in seconds

cases: $(STAMP) ### baselines beside references, both engines (RUNS="regress contract coarse", SCENES=, ACCEPT="scene:quantity", REFERENCES=scene)
	@echo "==> cases"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) benchmarks/cases.py $(RUNS) $(if $(SCENES),--scenes $(SCENES)) $(if $(ACCEPT),--accept $(ACCEPT)) \
	    $(if $(REFERENCES),--references $(REFERENCES))

publish: $(STAMP) ## both engines on the whole library, into reports/published: pages, figures, frozen values (PAGES=1: pages alone)
	@echo "==> publish"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) benchmarks/publishing.py $(if $(PAGES),--pages)
	@$(HOME_HERE) $(ONE_THREAD) $(PY) docs/pages.py

maps: $(STAMP) ### errors of theory for each kind of body, into reports/published/maps: tables, figures, pages (PAGES=1: pages alone)
	@echo "==> maps"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) -m reports map all --out reports/published/maps $(if $(PAGES),--pages)

peers: $(STAMP) ### other people's codes: CalculiX and GetFEM of Debian (asks for root); Kratos, tamaas, ContactMechanics (into .peers)
	@echo "==> peers: $(PEERS)"
	@if dpkg-query -W $(PEERS) >/dev/null 2>&1; then echo "there already"; else \
	    if [ "$$(id -u)" = 0 ]; then root=""; else root="sudo"; fi; \
	    $$root apt-get update && $$root apt-get install -y --no-install-recommends $(PEERS); \
	fi
	@echo "==> peers: the wheels of peers.txt, into .peers"
	@$(MAKE) --no-print-directory $(PEERS_STAMP)

examples: $(STAMP) ### docs/examples/score made anew with CalculiX and Kratos (after make peers), scored, their READMEs filled
	@echo "==> examples: CalculiX"
	@$(HOME_HERE) $(ONE_THREAD) docs/examples/score/calculix/make.sh
	@echo "==> examples: Kratos"
	@$(ONE_THREAD) docs/examples/score/kratos/make.sh
	@echo "==> examples: a path table"
	@$(HOME_HERE) $(ONE_THREAD) docs/examples/score/abaqus/make.sh
	@$(HOME_HERE) $(ONE_THREAD) $(PY) docs/examples/score/measure.py

docs: $(STAMP) ### the pages, into docs/_build/html
	@echo "==> docs: sphinx"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) -m sphinx -q -W --keep-going $(SPHINX) -b html -d .cache/doctrees docs docs/_build/html
	@echo "docs/_build/html/index.html"

pages: $(STAMP) ## what pages take from files, engines and their own examples: outputs, pictures, numbers, verification manual
	@echo "==> pages"
	@mkdir -p "$$TMPDIR" .cache/home
	@$(HOME_HERE) $(ONE_THREAD) $(PY) docs/report_picture.py
	@$(HOME_HERE) $(ONE_THREAD) $(PY) docs/pages.py
	@$(HOME_HERE) $(ONE_THREAD) $(PY) docs/executed.py

# Python compiles what is imported when it is imported: pip would compile all 12,000 files, for 50 s of one core.
# The stamps: what the program needs, then what tests, pages and tools need besides. A second call does nothing until pyproject.toml
# or constraints.txt changes; an interrupted one starts again.
$(PROGRAM): pyproject.toml constraints.txt
	@mkdir -p "$$TMPDIR" .cache/home
	@if ! $(PY) -m pip --version >/dev/null 2>&1; then \
	    python=""; \
	    for candidate in $(or $(PYTHON),python3 $(addprefix python,$(PYTHONS))); do \
	        version=$$($$candidate -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null || true); \
	        case " $(PYTHONS) " in *" $${version:-none} "*) python=$$candidate; break;; esac; \
	    done; \
	    if [ -z "$$python" ]; then \
	        echo "make: no Python among $(PYTHONS) found (tried $(or $(PYTHON),python3 $(addprefix python,$(PYTHONS))))" >&2; exit 1; \
	    fi; \
	    echo "==> .venv: a new environment from $$($$python --version)"; \
	    $$python -m venv --clear .venv; \
	fi
	@echo "==> .venv: the pinned packages that the program needs"
	@$(PY) -m pip install --no-compile -c constraints.txt hatchling editables
	@$(PY) -m pip install --no-compile -c constraints.txt --no-build-isolation -e .
	@echo "==> .venv: $$(du -sm .venv | cut -f1) MB on disk"
	@touch $@

$(STAMP): $(PROGRAM)
	@echo "==> .venv: the pinned packages of tests, pages and tools"
	@$(PY) -m pip install --no-compile -c constraints.txt --no-build-isolation -e ".[$(EXTRAS)]"
	@echo "==> .venv: $$(du -sm .venv | cut -f1) MB on disk"
	@touch $@

$(PEERS_STAMP): peers.txt
	@mkdir -p "$$TMPDIR"
	@$(PY) -m venv --clear .peers
	@.peers/bin/python -m pip install --no-compile -r peers.txt
	@touch $@

constraints: $(STAMP) ### renew constraints.txt: the newest packages that the oldest Python takes, each with wheels for all Pythons
	@echo "==> constraints: for Python $(PYTHONS)"
	@mkdir -p "$$TMPDIR"
	@$(UV) --universal --fork-strategy fewest --all-extras --upgrade --no-annotate --python-version $(firstword $(PYTHONS)) \
	    pyproject.toml -o "$$TMPDIR/pins"
	@{ grep '^#' constraints.txt; sed 's/ *;.*//' "$$TMPDIR/pins"; } > "$$TMPDIR/constraints"
	@mv "$$TMPDIR/constraints" constraints.txt
	@$(MAKE) --no-print-directory pins
	@git --no-pager diff --stat -- constraints.txt

pins: $(STAMP) ### look up whether every pin of constraints.txt has wheels for every Python
	@for version in $(PYTHONS); do \
	    $(UV) --no-deps --python-version $$version constraints.txt > /dev/null; \
	    echo "==> pins: all have wheels for Python $$version"; \
	done

clean: ### remove results and the tools' caches, keep .venv
	rm -rf out dist docs/_build .cache/compiled .cache/mypy .cache/ruff .cache/pytest .cache/import-linter .cache/hypothesis .cache/doctrees .cache/tmp
	find . -path ./.venv -prune -o -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean ### remove .venv, .peers and every cache too
	rm -rf .venv .peers .cache
