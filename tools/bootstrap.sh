#!/bin/sh
# Sets up .venv: Python environment and dependencies; swarm-setup does the rest.
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
}

# Prints the Debian packages that the system lacks, in one line.
missing_packages() {
    command -v "${CC:-gcc}" >/dev/null 2>&1 || echo gcc
    command -v "${CXX:-g++}" >/dev/null 2>&1 || echo g++
    found=$(find_python)
    if [ -z "$found" ]; then
        echo python3 python3-venv python3-dev
        return
    fi
    version=$("$found" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    if ! "$found" -c 'import venv, ensurepip' 2>/dev/null && [ ! -x .venv/bin/python ]; then
        echo "python$version-venv"
    fi
    header=$("$found" -c 'import sysconfig; print(sysconfig.get_path("include"))')/Python.h
    [ -f "$header" ] || echo "python$version-dev"
}

install_missing() {
    lacking=$(missing_packages | tr '\n' ' ')
    [ -z "$lacking" ] && return
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        echo "installing with apt: $lacking"
        # shellcheck disable=SC2086  # one word per package
        apt-get -qq update && DEBIAN_FRONTEND=noninteractive \
            apt-get -qq -y install --no-install-recommends $lacking >/dev/null ||
            fail "apt could not install $lacking"
        [ -n "$(find_python)" ] || fail "this system has no Python 3.11, 3.12 or 3.13
name one: make PYTHON=/path/to/python3.11"
    fi
    lacking=$(missing_packages | tr '\n' ' ')
    [ -z "$lacking" ] || fail "this system lacks $lacking
install it, then call make again: sudo apt install $lacking"
}

has_broker() {
    PATH=$PATH:/usr/sbin command -v mosquitto >/dev/null 2>&1
}

# The broker in the tests of VDA 5050. Nothing else needs it, so its lack does not end the set-up.
install_broker() {
    has_broker && return
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        echo "installing with apt: mosquitto"
        apt-get -qq update && DEBIAN_FRONTEND=noninteractive \
            apt-get -qq -y install --no-install-recommends mosquitto >/dev/null || true
    fi
    has_broker || echo "this system lacks mosquitto: tests of VDA 5050 that need it are skipped
install it with: sudo apt install mosquitto" >&2
}

# uv takes half of pip's time, but knows nothing of an index that pip is told of.
install_project() {
    pip=".venv/bin/python -m pip"
    if ! $pip config list | grep -q '\.index-url='; then
        folder=$(mktemp -d)
        trap 'rm -rf "$folder"' EXIT
        $pip install --quiet --only-binary uv --target "$folder" uv &&
            "$folder/bin/uv" pip install --quiet --python .venv/bin/python --compile-bytecode \
                --editable "$1" && return
    fi
    $pip install --quiet --editable "$1"
}

install_missing
case ",$extras," in
    *,vda5050,*) install_broker ;;
esac
if ! .venv/bin/python -m pip --version >/dev/null 2>&1; then
    python=$(find_python)
    echo "making .venv with $python"
    "$python" -m venv .venv
fi
echo "installing dependencies into .venv (a few minutes the first time)"
install_project ".${extras:+[$extras]}"
