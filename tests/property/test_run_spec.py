"""A run is a value: what --print-spec prints of a command line, --spec reads as the same run."""

import typing
from collections.abc import Mapping
from typing import Any

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from swarm_common.model.central import Coordination
from swarm_common.model.errors import ConfigError
from swarm_run.flags import parser, stated_of, text_of
from swarm_run.host_options import Role
from swarm_run.spec import RunSpec

TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=["C", "Z"], exclude_characters="/."), min_size=1
)
TEXTS |= st.sampled_from(["01", "no", "null", "1e3", "agv{:02}", "2026-01-01", "~", "a: b"])
NUMBERS = st.floats(1e-3, 1e9)
MAPPINGS = st.dictionaries(TEXTS, st.sampled_from(["all", "no", "a:B"]) | NUMBERS)
KINDS: dict[Any, st.SearchStrategy[Any]] = {
    bool: st.booleans(), int: st.integers(1, 10**6), float: NUMBERS, str: TEXTS,
    Coordination: st.sampled_from(Coordination), Role: st.sampled_from(Role),
    tuple[str, ...]: st.lists(TEXTS).map(tuple), type(None): st.none(),
    Mapping[str, Any]: MAPPINGS, tuple[Mapping[str, Any], ...]: st.lists(MAPPINGS).map(tuple),
}  # fmt: skip


def values_of(kind):
    kinds = typing.get_args(kind) if type(None) in typing.get_args(kind) else (kind,)
    return st.one_of(*(KINDS[each] for each in kinds))


HINTS = typing.get_type_hints(RunSpec)
FIELDS = {name: values_of(HINTS[name]) for name in RunSpec.__struct_fields__}
FIELDS["speed"] = st.sampled_from(["max", "2.5"]) | NUMBERS
FIELDS["pack"] = st.sampled_from(["auto", "7"]) | st.integers(1, 99)
FLAGS = {item.name: item for item in parser().params}


def read_back(spec, folder, *words):
    path = folder / "run.yaml"
    path.write_text(text_of(spec), encoding="utf-8")
    return RunSpec(**stated_of(parser().make_context("up", ["--spec", str(path), *words])))


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.fixed_dictionaries({}, optional=FIELDS))
def test_a_printed_run_is_the_same_run(values, tmp_path):
    spec = RunSpec(**values)
    assert read_back(spec, tmp_path) == spec


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(values=st.fixed_dictionaries({}, optional=FIELDS))
def test_flags_say_what_fields_say(values, tmp_path):
    words, stated = list[str](), dict[str, Any]()
    for name, value in values.items():
        if name not in FLAGS or value is None:
            continue
        flag = FLAGS[name]
        if flag.is_flag:
            words += flag.opts[:1] if value else flag.secondary_opts[:1]
        else:
            each = value if isinstance(value, tuple) else [value]
            words += [f"{flag.opts[0]}={one}" for one in each]
        stated[name] = str(value) if name in ("speed", "pack") else value
    spec = RunSpec(**{n: v for n, v in stated.items() if v or FLAGS[n].secondary_opts})
    assert RunSpec(**stated_of(parser().make_context("up", words))) == spec


def test_flags_beside_a_file_win(tmp_path):
    spec = read_back(RunSpec(world="hall_12", laps=3), tmp_path, "--laps", "2", "--viewer")
    assert spec == RunSpec(world="hall_12", laps=2, viewer=True)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("swarm_sise: 3", r"unknown key 'swarm_sise' in .*run.yaml, line 1; did you mean 'swarm_s"),
        ("world: hall_12\nlaps: 0", r"run.yaml, line 2: laps is 0; expected an integer, 1 or more"),
        ("coordination: centrl", "unknown coordination 'centrl'.* did you mean 'central'"),
        ("speed: [1]", "speed is .*; expected"),
    ],
)
def test_a_wrong_file_is_refused_in_our_words(text, said, tmp_path):
    (tmp_path / "run.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=said):
        stated_of(parser().make_context("up", ["--spec", str(tmp_path / "run.yaml")]))


def test_every_field_has_a_flag_or_is_for_files_and_programs():
    assert set(RunSpec.__struct_fields__) - FLAGS.keys() == {
        "parameters", "vda5050_faults", "external", "paused",
    }  # fmt: skip
    assert not msgspec.to_builtins(RunSpec())
