"""The workflow for GitHub: its form, and that what it calls is there."""

import os
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
WORKFLOW = ROOT / ".github" / "workflows" / "tests.yml"


def test_the_workflow_has_the_form_of_a_workflow():
    program = Path(sys.executable).parent / "check-jsonschema"
    command = [str(program), "--builtin-schema", "vendor.github-workflows", str(WORKFLOW)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_its_scripts_can_be_run():
    jobs = yaml.safe_load(WORKFLOW.read_text("utf-8"))["jobs"]
    words = [
        step["run"].split()[0] for job in jobs.values() for step in job["steps"] if "run" in step
    ]
    scripts = {word for word in words if "/" in word}
    assert scripts == {".ci/run", ".venv/bin/pytest", "tools/test_on_python.sh"}
    assert all(os.access(ROOT / name, os.X_OK) for name in scripts if not name.startswith(".venv"))


def test_later_pythons_are_those_that_the_project_admits():
    jobs = yaml.safe_load(WORKFLOW.read_text("utf-8"))["jobs"]
    later = jobs["later-python"]["strategy"]["matrix"]["python"]
    assert later == ["3.12", "3.13"]
    assert 'requires-python = ">=3.11,<3.14"' in (ROOT / "pyproject.toml").read_text("utf-8")
