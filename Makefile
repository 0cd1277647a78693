# make demo    all set-up, then 20 robots work through the factory hall
# make test    all set-up, then style, types, layering and all tests
# make setup   only the set-up that `demo` needs
# make docs    serves the documentation at http://127.0.0.1:8000 until Ctrl-C
# make clean   removes the environment and all runs
#
# Set-up is repeated only when what it depends on has changed. PYTHON=... names another Python.

PYTHON ?=
export PYTHON

inputs := pyproject.toml tools/bootstrap.sh $(shell find interfaces -type f)
live := tests/faults tests/graph tests/hosts
runs := tests/scenario
pure := $(filter-out $(live) $(runs),$(patsubst %/,%,$(wildcard tests/*/)))
DEMO := --swarm-size 20 --world slim_blockage --mission loading_route --until-done

.PHONY: help demo test test-live test-pure test-runs setup docs clean

help:
	@sed -n 's/^# \{0,1\}//p' $(firstword $(MAKEFILE_LIST))

demo: .venv/.ready-run
	.venv/bin/swarm-up $(DEMO)

test: .venv/.ready-test
	.venv/bin/ruff check .
	.venv/bin/ruff format --check --quiet .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-logo
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict --quiet
	# The kernels are compiled once, before several need them at the same time.
	.venv/bin/python -c "from swarm_nav.launch.warm_up import warm_up; warm_up()"
	$(MAKE) --jobs=2 --output-sync=target --no-print-directory test-live test-pure test-runs

# Live graphs on one core; everything else, and then whole runs, on another.
test-live test-pure test-runs: test-%: .venv/.ready-test
	.venv/bin/pytest $($*)

setup: .venv/.ready-run

docs: .venv/.ready-docs
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs serve

.venv/.ready-run: $(inputs)
	tools/bootstrap.sh
	@touch $@

.venv/.ready-test: $(inputs)
	tools/bootstrap.sh dev,bench,docs
	@touch $@ .venv/.ready-run .venv/.ready-docs

.venv/.ready-docs: $(inputs)
	tools/bootstrap.sh docs
	@touch $@ .venv/.ready-run

clean:
	rm -rf .venv runs
