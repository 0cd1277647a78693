"""Who installs the dependencies: uv, unless pip is told of an index or uv fails."""

import shutil
import subprocess
from pathlib import Path

import pytest

BOOTSTRAP = Path(__file__).parents[2] / "tools" / "bootstrap.sh"
PYTHON = """#!/bin/sh
echo "pip $*" >>"$LOG"
case "$*" in
*"config list") echo "$PIP_TOLD" ;;
*" uv")
    mkdir -p "$8/bin"
    printf '#!/bin/sh\\necho "uv $*" >>"$LOG"\\nexit "$UV_CODE"\\n' >"$8/bin/uv"
    chmod +x "$8/bin/uv" ;;
esac
"""


@pytest.mark.parametrize(
    ("told", "code", "installers"),
    [
        ("global.extra-index-url='https://example.org'", 0, ["uv"]),
        ("global.index-url='https://example.org'", 0, ["pip"]),
        ("", 2, ["uv", "pip"]),
    ],
)
def test_dependencies_are_installed_by_whoever_can(told, code, installers, tmp_path):
    (tmp_path / "tools").mkdir()
    shutil.copy(BOOTSTRAP, tmp_path / "tools")
    python = tmp_path / ".venv/bin/python"
    python.parent.mkdir(parents=True)
    python.write_text(PYTHON, encoding="utf-8")
    python.chmod(0o755)
    log, temporary = tmp_path / "log", tmp_path / "temporary"
    temporary.mkdir()
    subprocess.run(
        [str(tmp_path / "tools/bootstrap.sh"), "dev"],
        env={"PATH": "/usr/sbin:/usr/bin:/bin", "LOG": str(log), "TMPDIR": str(temporary),
             "PIP_TOLD": told, "UV_CODE": str(code)},
        check=True,
    )  # fmt: skip
    lines = log.read_text(encoding="utf-8").splitlines()
    assert [line.split()[0] for line in lines if "--editable .[dev]" in line] == installers
    assert list(temporary.iterdir()) == []
