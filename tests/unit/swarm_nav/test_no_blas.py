"""Decisions do not depend on the processor: BLAS picks its kernels by it, and rounds by them."""

import ast
from pathlib import Path

import pytest

import swarm_nav

ROOT = Path(swarm_nav.__file__).parent
FOLDERS = sorted(path for path in ROOT.iterdir() if path.is_dir() and path.name != "ros")
PRODUCTS = {"dot", "vdot", "inner", "matmul", "tensordot", "einsum", "linalg"}


def products(text):
    """Return the lines in which code leaves a product to BLAS."""
    return [
        node.lineno
        for node in ast.walk(ast.parse(text))
        if (isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult))
        or (isinstance(node, ast.Attribute) and node.attr in PRODUCTS)
    ]


def test_products_are_found():
    assert products("a = b @ c\nd = np.dot(b, c)\ne = np.linalg.norm(b)\nf = b * c\n") == [1, 2, 3]


@pytest.mark.parametrize("folder", FOLDERS, ids=lambda folder: folder.name)
def test_decisions_leave_no_product_to_blas(folder):
    """The scalar product of two numbers each made the last bits of a run those of a processor."""
    found = {path.name: products(path.read_text("utf-8")) for path in folder.rglob("*.py")}
    assert {name: lines for name, lines in found.items() if lines} == {}
