# make demo    all set-up, then 20 robots at work in the factory hall, with the viewer
# make test    all set-up, then style, types, layering and all tests
# make setup   only the set-up that `demo` needs
# make docs    serves the documentation at http://127.0.0.1:8000 until Ctrl-C
# make clean   removes the environment and all runs
#
# Set-up is repeated only when what it depends on has changed. PYTHON=... names another Python.

PYTHON ?=
export PYTHON

inputs := pyproject.toml tools/bootstrap.sh $(shell find interfaces -type f)
live := $(wildcard tests/graph/test_[a-m]*.py)
graph := $(filter-out $(live),$(wildcard tests/graph/test_*.py)) tests/graph/world \
	tests/graph/middleware
faults := tests/faults tests/hosts
robots := tests/scenario/test_own_robots.py
worlds := tests/scenario/test_other_peoples_worlds.py
hall := tests/scenario/test_factory_hall.py
controllers := tests/scenario/test_any_controller.py
wheel := tests/scenario/test_wheel.py
runs := $(filter-out $(robots) $(worlds) $(hall) $(controllers) $(wheel),$(wildcard tests/scenario/test_*.py))
commands := tests/unit/swarm_bench tests/unit/swarm_commander tests/unit/swarm_report $(controllers)
pure := $(filter-out tests/graph $(faults) tests/scenario tests/unit,$(patsubst %/,%,$(wildcard tests/*/))) \
	$(filter-out $(commands),$(patsubst %/,%,$(wildcard tests/unit/*/))) $(wildcard tests/unit/*.py)
DEMO := --swarm-size 20 --world slim_blockage --mission loading_route --viewer

.PHONY: help demo test test-style test-compiled test-kernels test-live test-graph test-faults test-pure test-commands test-robots \
	test-worlds test-hall test-runs test-wheel setup docs clean

help:
	@sed -n '/^#/!q; s/^# \{0,1\}//p' $(firstword $(MAKEFILE_LIST))

demo: .venv/.ready-run
	.venv/bin/swarm-up $(DEMO)

# Tests wait for processes, so four jobs at a time keep two cores busy.
test: .venv/.ready-test
	$(MAKE) --jobs=4 --output-sync=target --no-print-directory test-compiled test-kernels test-style \
		test-pure test-graph test-runs test-commands test-live test-wheel test-faults test-robots test-worlds \
		test-hall

test-style: .venv/.ready-test
	.venv/bin/ruff check .
	.venv/bin/ruff format --check --quiet .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-logo
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs build --strict

test-compiled: .venv/.ready-test
	.venv/bin/swarm-setup
	@touch .venv/.ready-run
	.venv/bin/python -c "from swarm_common.process.compiled_code import is_compiled; is_compiled() or exit('navigators are not compiled')"

# The kernels are those of compiled navigators, too.
test-kernels: .venv/.ready-test
	SWARM_INTERPRETED=1 .venv/bin/python -c "from swarm_nav.launch.warm_up import warm_up; warm_up()"

# What takes longest starts first, once navigators and kernels are compiled, as users have them.
test-live test-graph test-faults test-pure test-commands test-robots test-worlds test-hall test-runs test-wheel: test-%: test-compiled test-kernels
	.venv/bin/pytest $($*)

setup: .venv/.ready-run

docs: .venv/.ready-docs
	NO_MKDOCS_2_WARNING=1 .venv/bin/mkdocs serve

.venv/.ready-run: $(inputs)
	tools/bootstrap.sh
	.venv/bin/swarm-setup
	@touch $@

.venv/.ready-test: $(inputs)
	tools/bootstrap.sh dev,bench,docs,vda5050
	@touch $@ .venv/.ready-docs

.venv/.ready-docs: $(inputs)
	tools/bootstrap.sh docs
	@touch $@

clean:
	rm -rf .venv runs
