#!/bin/sh
# Runs the unit and the graph tests on another Python, in an environment of its own under build/.
# Usage: tools/test_on_python.sh python3.12 [PYTEST ARGUMENTS]     (default: tests/unit tests/graph)
set -eu
cd "$(dirname "$0")/.."
python=${1:?usage: tools/test_on_python.sh PYTHON [PYTEST ARGUMENTS]}
shift
version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
venv=build/python$version
mkdir -p build
touch build/COLCON_IGNORE # the environment's packages are none of a workspace around us
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
echo "installing dependencies into $venv"
"$venv/bin/python" -m pip install --quiet --editable ".[dev,bench]"
"$venv/bin/swarm-setup"
# The kernels are compiled once, before several tests need them at once.
"$venv/bin/python" -c "from swarm_nav.launch.warm_up import warm_up; warm_up()"
[ $# -gt 0 ] || set -- tests/unit tests/graph
exec "$venv/bin/python" -m pytest "$@"
