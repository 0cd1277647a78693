"""Byte code is written where Python was told not to, and only there."""

import importlib.util
import sys
from pathlib import Path

import pytest

from swarm_common.process.start import ensure_bytecode


@pytest.fixture
def module(tmp_path):
    file = tmp_path / "pack" / "inner" / "module.py"
    file.parent.mkdir(parents=True)
    file.write_text("VALUE = 1\n", encoding="utf-8")
    return file


def compiled(module):
    return Path(importlib.util.cache_from_source(str(module)))


def test_it_is_written_once(module, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    folder = module.parents[1]
    ensure_bytecode([folder, folder / "missing"])
    first = compiled(module).stat().st_mtime_ns
    ensure_bytecode([folder])
    assert compiled(module).stat().st_mtime_ns == first


def test_a_broken_module_is_left_to_its_importer(module, monkeypatch):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    module.write_text("VALUE =\n", encoding="utf-8")
    ensure_bytecode([module.parents[1]])
    assert not compiled(module).exists()
