#!/bin/sh
# Sets up .venv: Python environment, dependencies, ROS 2 interface packages.
# Usage: tools/bootstrap.sh [EXTRAS]      (extras of pyproject.toml, like dev,bench)
# Called by the Makefile, which skips it while nothing has changed since.
set -eu
cd "$(dirname "$0")/.."
extras=${1:-}

fail() {
    echo "error: $1" >&2
    exit 2
}

find_python() {
    for candidate in "${PYTHON:-}" python3.11 python3.12 python3.13 python3; do
        if [ -n "$candidate" ] && command -v "$candidate" >/dev/null 2>&1 &&
            "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info < (3, 14))'; then
            echo "$candidate"
            return
        fi
    done
    fail "no Python 3.11, 3.12 or 3.13 found (3.11 is best: PyBullet has ready wheels for it);
install it: sudo apt install python3.11 python3.11-venv python3.11-dev
or name it: make PYTHON=/path/to/python3.11"
}

make_venv() {
    version=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    if "$python" -c 'import venv, ensurepip' 2>/dev/null; then
        "$python" -m venv .venv
    elif "$python" -m pip --version >/dev/null 2>&1; then
        # Debian splits ensurepip off; the system's pip can fill the environment as well.
        "$python" -m venv --without-pip .venv
        "$python" -m pip --quiet --python .venv/bin/python install pip
    else
        fail "Python $version cannot make virtual environments;
install what is missing: sudo apt install python$version-venv"
    fi
}

for compiler in "${CC:-gcc}" "${CXX:-g++}"; do
    command -v "$compiler" >/dev/null 2>&1 ||
        fail "the compiler $compiler is missing, which the ROS 2 interface packages need;
install it: sudo apt install gcc g++"
done
if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    python=$(find_python)
    echo "making .venv with $python"
    make_venv
fi
echo "installing dependencies into .venv (a few minutes the first time)"
.venv/bin/python -m pip install --quiet --upgrade pip
.venv/bin/python -m pip install --quiet --editable ".${extras:+[$extras]}"
.venv/bin/swarm-setup
