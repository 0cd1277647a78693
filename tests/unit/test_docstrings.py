"""Docstrings: a folder's lists its modules, and an entry of an argument says something."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROW = re.compile(r"^    (\w+)  +\S", re.MULTILINE)
MAPS = {
    path.parent: rows
    for path in sorted(ROOT.glob("swarm_*/**/__init__.py"))
    if (rows := set(ROW.findall(ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "")))
}
# What users import, and the kernels: here each parameter has an entry.
PUBLIC = (
    "swarm_bench/runs/harness.py",
    "swarm_bench/runs/result.py",
    "swarm_bench/runs/scenario.py",
    "swarm_bench/runs/episode.py",
    "swarm_run/robots/client.py",
    "swarm_run/robots/task.py",
    "swarm_nav/interfaces.py",
)
FEWEST_WORDS = 5  # of an entry; fewer only with a unit, a shape, a value or what None means
SAYS_MORE = re.compile(r"[`\[(\d]|None|if |whether|frame|map|default", re.IGNORECASE)
ARGS = re.compile(r"^Args:\n((?: {4}.*\n?|\n)+)", re.MULTILINE)
SHARED = re.compile(r"^Args of more than one kernel:\n((?: {4}.*\n?|\n)+)", re.MULTILINE)
NAMED_TUPLES = {
    name
    for path in ROOT.glob("swarm_*/**/*.py")
    for name in re.findall(r"^class (\w+)\(NamedTuple\)", path.read_text("utf-8"), re.MULTILINE)
}
ENTRY = re.compile(r"^ {4}\*{0,2}(\w+): (\S.*(?:\n {8}.*)*)", re.MULTILINE)
Function = ast.FunctionDef | ast.AsyncFunctionDef


@pytest.mark.parametrize("folder", MAPS, ids=lambda folder: str(folder.relative_to(ROOT)))
def test_a_folders_map_names_its_modules(folder):
    modules = {path.stem for path in folder.glob("*.py")} - {"__init__", "__main__"}
    folders = {path.parent.name for path in folder.glob("*/__init__.py")}
    assert modules <= MAPS[folder], "not on the map"
    assert MAPS[folder] <= modules | folders, "not there"


def test_the_folders_of_the_large_packages_have_maps():
    assert {"swarm_nav", "swarm_sim", "swarm_view", "swarm_bench"} <= {
        folder.relative_to(ROOT).parts[0] for folder in MAPS
    }


def functions_of(path):
    yield from public_functions(ast.parse(path.read_text("utf-8")), False)


@pytest.mark.parametrize("name", PUBLIC)
def test_what_users_import_describes_its_parameters(name):
    wrong = [
        f"{function.lineno} {function.name}: {', '.join(missing)}"
        for function, is_method in functions_of(ROOT / name)
        if (missing := sorted(parameters(function, is_method) ^ described(function).keys()))
    ]
    assert not wrong, "without a line under Args:, or no parameter"


@pytest.mark.parametrize("path", sorted(ROOT.glob("swarm_*/**/*_kernels.py")), ids=lambda p: p.stem)
def test_kernels_describe_their_parameters(path):
    """Each has an entry, there or at the top for several kernels, or is a NamedTuple."""
    top = SHARED.search(ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "")
    shared = dict(ENTRY.findall(top[1])) if top else {}
    wrong = [
        f"{function.lineno} {function.name}: {', '.join(sorted(missing))}"
        for function, is_method in functions_of(path)
        if (
            missing := (parameters(function, is_method) ^ described(function).keys())
            - shared.keys()
            - tuples_of(function)
        )
    ]
    assert not wrong, "without a line under Args:, or no parameter"


def tuples_of(function):
    kinds = {
        each.arg: ast.unparse(each.annotation or ast.Constant(0)) for each in function.args.args
    }
    return {name for name, kind in kinds.items() if kind.partition("[")[0] in NAMED_TUPLES}


def test_an_entry_says_more_than_name_and_type():
    wrong = [
        f"{path.relative_to(ROOT)}:{function.lineno} {function.name}: {name}: {text}"
        for path in sorted(ROOT.glob("swarm_*/**/*.py"))
        if not path.stem.endswith("_kernels") and str(path.relative_to(ROOT)) not in PUBLIC
        for function, is_method in functions_of(path)
        for name, text in described(function).items()
        if name not in parameters(function, is_method)
        or (len(text.split()) < FEWEST_WORDS and not SAYS_MORE.search(text))
    ]
    assert not wrong, "an entry that says nothing, or of no parameter:\n" + "\n".join(wrong)


def public_functions(node, is_class):
    """Yield the public functions below a node, nested ones too, and whether each is a method."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.ClassDef):
            if not child.name.startswith("_"):
                yield from public_functions(child, True)
        elif isinstance(child, Function):
            is_public = not child.name.startswith("_") or child.name == "__init__"
            if is_public and not is_command(child):
                yield child, is_class
            yield from public_functions(child, False)
        else:
            yield from public_functions(child, is_class)


def is_command(function):
    """Whether it is a command: its docstring is its --help, and its options have own texts."""
    calls = (item.func for item in function.decorator_list if isinstance(item, ast.Call))
    return any(isinstance(call, ast.Attribute) and call.attr == "command" for call in calls)


def parameters(function, is_method):
    """Return the names of a function's parameters without self and cls, and without `_`."""
    given = function.args
    names = [item.arg for item in (*given.posonlyargs, *given.args)]
    decorators = {item.id for item in function.decorator_list if isinstance(item, ast.Name)}
    if is_method and "staticmethod" not in decorators:
        del names[0]
    names += [item.arg for item in (given.vararg, *given.kwonlyargs, given.kwarg) if item]
    return {name for name in names if not name.startswith("_")}


def described(function):
    """Return the entries under `Args:` in the docstring of a function."""
    section = ARGS.search(ast.get_docstring(function) or "")
    return dict(ENTRY.findall(section[1])) if section else {}
