import os
import py_compile
import sys
from pathlib import Path

import pytest

from tests.fakes.programs import run_program

HEADER = 16  # bytes in front of the code of a .pyc


@pytest.mark.parametrize("kept", [HEADER, HEADER + 40, -1])
def test_a_module_whose_compiled_file_was_cut_short_is_compiled_anew(tmp_path, kept):
    compiled = _compiled(tmp_path)
    compiled.write_bytes(compiled.read_bytes()[:kept])
    assert _imported(tmp_path) == "42"
    assert _imported(tmp_path) == "42"
    assert "EOFError" not in _imported(tmp_path, guard="pass"), "it was written again"


def test_a_module_whose_compiled_file_has_a_hole_is_compiled_anew(tmp_path):
    compiled = _compiled(tmp_path)
    content = compiled.read_bytes()
    compiled.write_bytes(content[:HEADER] + bytes(len(content) - HEADER))
    assert _imported(tmp_path) == "42"


def test_python_itself_does_not_get_over_it(tmp_path):
    compiled = _compiled(tmp_path)
    compiled.write_bytes(compiled.read_bytes()[:-1])
    assert "EOFError" in _imported(tmp_path, guard="pass")


def test_a_module_that_is_wrong_itself_says_so(tmp_path):
    (tmp_path / "module_of_forty_two.py").write_text("int('seven')\n")
    assert "invalid literal for int" in _imported(tmp_path)
    (tmp_path / "module_of_forty_two.py").write_text("VALUE = (\n")
    assert "SyntaxError" in _imported(tmp_path)


def _compiled(folder):
    source = folder / "module_of_forty_two.py"
    source.write_text("VALUE = 42\n\n\ndef value():\n    return VALUE + len(__name__)\n")
    return Path(str(py_compile.compile(str(source), doraise=True)))


def _imported(folder, guard="from swarm_common.process.start import prepare; prepare()"):
    done = run_program(
        [sys.executable, "-c", f"{guard}\nimport module_of_forty_two as m\nprint(m.VALUE)"],
        {"PYTHONPATH": os.pathsep.join([str(folder), *sys.path])},
    )
    return done.stdout.strip() or done.stderr
