"""The YAML itself: keys that stand twice, scalars of YAML 1.2, anchors, any text and any damage."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navigation.config import ConfigError, parse_config
from navigation.config.marks import read_document
from tests.navigation.config.texts import GOOD, problems_of, text_of_error

# The YAML itself.


def test_a_key_that_stands_twice_is_an_error_at_the_second() -> None:
    told = text_of_error(GOOD + "camera: {source: 0}\n")
    assert told.startswith("run.yaml:12:1: the key 'camera' is here a second time, first in line 3")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("# only a comment\n", "is empty"),
        ("- 1\n- 2\n", "must be sections"),
        ("arena: [1, 2\ncamera: 3\n", "not YAML: "),
        ("arena: {a: b: c}\n", "not YAML: "),
        ("a: \x00\n", "not YAML: the character '\\x00' is not allowed"),
        ("a: &x [*x]\n", "an alias inside itself"),
        ("? [1, 2]\n: 3\n", "a key must be a word"),
        ("3: 4\n", "a key must be a word"),
        ("a: *nowhere\n", "not YAML: found undefined alias"),
        ("a: !!python/object:os.system {}\n", ""),
        ("\ta: 1\n", "not YAML: a tab: must be spaces"),
        ("a:\n\tb: 1\n", "not YAML: a tab: must be spaces"),
        ("a: 1\n---\nb: 2\n", "not YAML: "),
        ("a: !!timestamp x\n", ""),
        ("a: !!binary x\n", ""),
    ],
)
def test_what_is_not_a_configuration_at_all_is_a_clear_error(text: str, message: str) -> None:
    messages = [told for _, told in problems_of(text)]
    assert any(message in told for told in messages)


def test_a_colon_without_a_space_is_reported_at_its_own_line() -> None:
    told = text_of_error("robot:\n  marker_id: 7\n  radius_m:0.09\n  # its words\n  driver: a\n")
    assert told.startswith("run.yaml:3:3: not YAML: must be `key: value`, with a space")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 0.001),
        ("1.5E3", 1500.0),
        ("0x10", 16),
        ("010", 10),
        ("1_000", "1_000"),
        ("on", "on"),
        ("no", "no"),
        ("12:30", "12:30"),
        ("2026-01-01", "2026-01-01"),
        ("true", True),
        ("~", None),
        ("'3'", "3"),
        (".5", 0.5),
        ("-.inf", -math.inf),
    ],
)
def test_scalars_are_those_of_yaml_1_2(text: str, value: object) -> None:
    assert read_document(text).data == value


def test_an_anchor_may_be_used_again() -> None:
    assert read_document("a: &p [1, 2]\nb: *p\n").data == {"a": [1, 2], "b": [1, 2]}


_SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(10**9), 10**9)
    | st.floats(allow_nan=False)
    | st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")))
)
_TREES = st.recursive(
    _SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.from_regex(r"[a-z]{1,5}x", fullmatch=True), inner, max_size=3)
    ),
    max_leaves=12,
)


@given(_TREES)
def test_what_json_writes_is_read_back_with_a_mark_for_every_value(tree: Any) -> None:
    import json

    document = read_document(json.dumps(tree, ensure_ascii=False) if _finite(tree) else "{}")
    if not _finite(tree):
        return
    assert document.defects == []
    assert document.data == tree
    assert set(document.values) == set(_locations(tree, ()))


def _finite(tree: Any) -> bool:
    if isinstance(tree, dict):
        return all(_finite(v) for v in tree.values())
    if isinstance(tree, list):
        return all(_finite(v) for v in tree)
    return not isinstance(tree, float) or math.isfinite(tree)


def _locations(tree: Any, at: tuple[str | int, ...]) -> list[tuple[str | int, ...]]:
    inner: list[tuple[str | int, Any]] = []
    if isinstance(tree, dict):
        inner = list(tree.items())
    elif isinstance(tree, list):
        inner = list(enumerate(tree))
    return [at, *(where for key, value in inner for where in _locations(value, (*at, key)))]


@given(st.text())
def test_no_text_does_anything_but_load_or_raise_a_configuration_error(text: str) -> None:
    with pytest.raises(ConfigError):
        parse_config(text)


@given(
    st.sampled_from(GOOD.split()), st.sampled_from(["", "[", "{", "x: ", "- ", "&a ", "1", "\t"])
)
def test_a_damaged_configuration_loads_or_is_refused_with_a_place(word: str, put: str) -> None:
    told = _attempt(GOOD.replace(word, put, 1))
    assert told is None or (told.problems and all(problem.message for problem in told.problems))


def _attempt(text: str) -> ConfigError | None:
    try:
        parse_config(text, "run.yaml")
    except ConfigError as error:
        return error
    return None
