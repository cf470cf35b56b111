# Every target that runs Python first creates .venv, and again when its requirements change.
# MODELS: wheels kept in .venv/models for the MJCF files in them, not installed: their requirements
# would bring a second mujoco.
PYTHON ?= python3
WORKERS ?= 2
EXTRAS ?= suite,dev
MODELS ?= gymnasium==1.4.0 gymnasium-robotics==1.4.2 dm_control==1.0.50 robosuite-models==1.0.0 \
    myo-sim==0.2.4
BIN := .venv/bin
SINCE ?= HEAD^
MUTANTS = .venv/mutants-$(shell git rev-parse --short HEAD)-since-$(shell git rev-parse --short $(SINCE) 2>/dev/null)
# Tests of runs, which the general kernel does with GALVI_FAST=0; other tests would only be run twice.
CORE := integrate order corners group_conservation group_systems lagrangian_scales \
    trajectory pieces events assessed_when_asked problems external_forces \
    differences component_degrees limits_of_rounding calling own_space engines \
    end_of_step trees_of_engines interop compilation brownout
STAMP := .venv/installed-$(EXTRAS)

# Tests and reports start many processes, which would compile every source anew.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: install test core slow check report docs studies mutants bench newest native clean help

help: ## list the targets
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "%-9s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)
	@echo 'The first one creates .venv with $(PYTHON); choose another with PYTHON=path/to/python3.'

install: $(STAMP) ## create .venv and install galvi, the suite and the tools

test: $(STAMP) ## run the tests except those marked slow or browser
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal

core: $(STAMP) ## run the tests of runs by the general kernel alone
	GALVI_FAST=0 $(BIN)/python -m pytest -n $(WORKERS) --dist worksteal tests/users/test_users_errors.py \
	    $(CORE:%=tests/properties/test_%.py)

slow: $(STAMP) ## run the tests marked slow
	$(BIN)/python -m pytest -n $(WORKERS) --dist worksteal -m 'slow and not browser'

check: $(STAMP) ## lint, formatting, types, import contracts
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

report: $(STAMP) ## verify and compare; write tables, figures and the site to reports/out; FULL=1: all studies, longer
	$(BIN)/python -m reports $(if $(FULL),,--quick)

docs: $(STAMP) ## write the site with the tutorials run, around whatever rows there are; a warning fails
	$(BIN)/python -m reports build --kept --tutorials

studies: $(STAMP) ## run the long studies (hours); resumes after an interruption
	$(BIN)/python -m reports studies

mutants: $(STAMP) ## plant small faults in lines of galvi changed since SINCE, and list those that no test finds; resumes
	@$(BIN)/python -c 'import cosmic_ray' 2>/dev/null || $(BIN)/python -m pip install \
	    --quiet --disable-pip-version-check -e '.[$(EXTRAS),mutants]' -c constraints.txt
	@set -e; since=$$(git rev-parse --quiet --verify '$(SINCE)^{commit}') || { \
	    echo "SINCE must name a commit of this repository; received $(SINCE)." >&2; exit 2; }; \
	test -d $(MUTANTS) || git clone --quiet --shared . $(MUTANTS); cd $(MUTANTS); \
	export PATH="$(abspath $(BIN)):$$PATH" PYTHONPATH="$$PWD"; \
	if test ! -e mutants.sqlite; then \
	    git branch --force before "$$since"; \
	    changed=$$(git diff --name-only --diff-filter=d before -- 'galvi/*.py' | sed 's/.*/"&",/'); \
	    sed "s#^module-path = .*#module-path = [$$(echo $$changed)]#" cosmic-ray.toml > mutants.toml; \
	    cosmic-ray init mutants.toml new.sqlite; \
	    cr-filter-operators new.sqlite mutants.toml; \
	    cr-filter-git --config mutants.toml new.sqlite; \
	    cosmic-ray baseline mutants.toml; \
	    mv new.sqlite mutants.sqlite; \
	fi; \
	cosmic-ray exec mutants.toml mutants.sqlite; \
	cr-report --surviving-only --show-diff mutants.sqlite

bench: $(STAMP) ## time steps, trajectories and references, and store the times; QUICK=1: a few
	$(BIN)/python -m pytest benchmarks --benchmark-enable --benchmark-only $(if $(QUICK),-m quick)

newest: $(STAMP) ## install the newest engines in .venv/newest, and say what moves otherwise with them
	$(PYTHON) -m venv .venv/newest
	.venv/newest/bin/python -m pip install --quiet --disable-pip-version-check --upgrade \
	    --upgrade-strategy eager -e '.[suite,peers]'
	.venv/newest/bin/python -m benchmarks.studies.signatures --write .venv/newest/signatures.csv
	$(BIN)/python -m benchmarks.studies.signatures .venv/newest/signatures.csv

native: $(STAMP) ## build REBOUND for this processor, as a further contender of the comparisons
	CFLAGS='-O3 -march=native' $(BIN)/python -m pip install --quiet --disable-pip-version-check \
	    --no-cache-dir --no-deps --no-binary rebound --upgrade --target .venv/native \
	    -c constraints.txt rebound

clean: ## remove .venv, caches and build output, but not reports/out
	rm -rf .venv build dist *.egg-info .pytest_cache .mypy_cache .ruff_cache .hypothesis \
	    .import_linter_cache .benchmarks docs/generated
	find galvi references benchmarks reports tests -name __pycache__ -prune -exec rm -rf {} +

$(STAMP): pyproject.toml setup.py constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	    version=$$($(PYTHON) --version 2>&1) || version='not a Python that runs'; \
	    echo "galvi needs Python 3.11 or newer, but $(PYTHON) is $$version;" \
	         "name another, as in: make $(or $(firstword $(MAKECMDGOALS)),install) PYTHON=path/to/python3" >&2; \
	    exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --no-compile --disable-pip-version-check \
	    -e '.[$(EXTRAS)]' -c constraints.txt
	@$(BIN)/python -m pip download --quiet --no-deps --disable-pip-version-check \
	    -d .venv/models $(MODELS) || echo 'The models of $(MODELS) are not here: their tests are skipped.'
	@$(BIN)/python -m compileall -qq -j 0 -x '/tests/' .venv/lib || true # as pip would, one by one
	@touch $@
