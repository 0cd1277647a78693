# make demo    all set-up, then 20 robots work through the factory hall
# make test    all set-up, then style, types, layering and all tests
# make setup   only the set-up that `demo` needs
# make clean   removes the environment and all runs
#
# Set-up is repeated only when what it depends on has changed. PYTHON=... names another Python.

PYTHON ?=
export PYTHON

inputs := pyproject.toml tools/bootstrap.sh $(shell find interfaces -type f)
DEMO := --swarm-size 20 --world slim_blockage --mission loading_route --until-done

.PHONY: help demo test setup clean

help:
	@sed -n 's/^# \{0,1\}//p' $(firstword $(MAKEFILE_LIST))

demo: .venv/.ready-run
	.venv/bin/swarm-up $(DEMO)

test: .venv/.ready-test
	.venv/bin/ruff check .
	.venv/bin/ruff format --check --quiet .
	.venv/bin/mypy
	.venv/bin/lint-imports --no-logo
	.venv/bin/pytest

setup: .venv/.ready-run

.venv/.ready-run: $(inputs)
	tools/bootstrap.sh
	@touch $@

.venv/.ready-test: $(inputs)
	tools/bootstrap.sh dev,bench
	@touch $@ .venv/.ready-run

clean:
	rm -rf .venv runs
