"""Values put into a configuration's text: the data is what was meant, all else stays."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from navigation.config.editing.in_text import EditError, value_text, with_values
from navigation.config.marks import Location, read_document

CONFIGS = sorted((Path(__file__).parents[3] / "configs").glob("*.yaml"))
WORDS = st.text("abcdefgh_", min_size=1, max_size=6)
PLAIN = (
    st.booleans()
    | st.integers(-(10**6), 10**6)
    | st.floats(-1e6, 1e6)
    | st.text(max_size=12)
    | st.lists(st.integers(-5, 5) | st.text("ab :#'\"", max_size=4), max_size=4)
)
TREES = st.recursive(
    PLAIN, lambda inner: st.dictionaries(WORDS, inner, min_size=1, max_size=4), max_leaves=12
)
SECTIONS = st.dictionaries(WORDS, TREES, min_size=1, max_size=4)


@st.composite
def a_text(draw: st.DrawFn) -> tuple[str, dict[str, Any]]:
    """A text in one of YAML's styles, with comments of its own, and its data."""
    data = draw(SECTIONS)
    flow = draw(st.sampled_from([False, None]))
    text = yaml.safe_dump(data, default_flow_style=flow, allow_unicode=True, width=10**6)
    if draw(st.booleans()):
        lines = text.splitlines()
        ends = [line + "  # said" if line.endswith(":") else line for line in lines]
        text = "# heading\n" + "\n".join(ends) + "\n# end\n"
    held = read_document(text)
    if held.defects or not isinstance(held.data, dict):
        return "a: 1\n", {"a": 1}
    return text, held.data


def keys_of(data: dict[str, Any], at: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found = []
    for key, value in data.items():
        found.append((*at, key))
        if isinstance(value, dict):
            found += keys_of(value, (*at, key))
    return found


def put(data: dict[str, Any], where: tuple[str, ...], value: Any) -> None:
    *outer, last = where
    for key in outer:
        data = data[key]
    data[last] = value


@given(a_text(), st.data())
def test_what_is_changed_is_what_was_meant_or_refused(
    made: tuple[str, dict[str, Any]], data: st.DataObject
) -> None:
    """The oracle is the plain data; PyYAML reads back what the editor wrote."""
    text, held = made
    where = data.draw(st.sampled_from(keys_of(held)))
    value = data.draw(PLAIN)
    try:
        changed = with_values(text, {where: value})
    except EditError:
        return  # nothing was written
    put(held, where, value)
    assert read_document(changed).data == held
    if "# heading" in text:
        assert changed.startswith("# heading\n")
        assert changed.endswith("# end\n")


@given(st.sampled_from(CONFIGS), st.data())
def test_every_number_of_a_shipped_configuration_can_be_changed_and_changed_back(
    file: Path, data: st.DataObject
) -> None:
    text = file.read_text()
    held = read_document(text).data
    numbers = [k for k in keys_of(held) if type(at(held, k)) in (int, float)]
    where = data.draw(st.sampled_from(numbers))
    other = with_values(text, {where: 123.25})
    lines, before = other.splitlines(), text.splitlines()
    assert len(lines) == len(before)
    assert sum(a != b for a, b in zip(lines, before, strict=True)) == 1
    back = with_values(other, {where: at(held, where)})
    assert read_document(back).data == held


def at(data: Any, where: tuple[str, ...]) -> Any:
    for key in where:
        data = data[key]
    return data


@pytest.mark.parametrize(
    ("text", "where", "value", "changed"),
    [
        ("a:\n  b: 1    # why\n", ("a", "b"), 12, "a:\n  b: 12   # why\n"),
        ("a:\n  b: 1\n\nc: {}\n", ("a", "d"), "x", "a:\n  b: 1\n  d: x\n\nc: {}\n"),
        ("a:\n  b: 1  # why\nc:\n", ("a", "d"), 2.0, "a:\n  b: 1  # why\n  d: 2\nc:\n"),
        ("a: {b: 1}\n", ("a", "d"), True, "a: {b: 1, d: true}\n"),
        ("a: {}\n", ("a", "d"), [1, 2], "a: {d: [1, 2]}\n"),
        ("a: 1\n", ("s", "d"), 3, "a: 1\n\ns:\n  d: 3\n"),
        ("a: 1\ns:\n", ("s", "d"), 3, "a: 1\ns: {d: 3}\n"),
        ("a: 1\n", ("s", "t", "d"), 3, "a: 1\n\ns:\n  t: {d: 3}\n"),
        ("a:\n  b: 1\n  # more\n  c: 2\n", ("a", "b"), None, "a:\n  # more\n  c: 2\n"),
        ("a:\n  b: 1\nc: 2\n", ("a", "b"), None, "a: {}\nc: 2\n"),
        ("a: {b: 1, c: 2}\n", ("a", "b"), None, "a: {c: 2}\n"),
        ("a: {b: 1, c: 2}\n", ("a", "c"), None, "a: {b: 1}\n"),
        ("a:\n  b:\n    - 1\n    - 2\n  c: 3\n", ("a", "b"), [5], "a:\n  b:\n    [5]\n  c: 3\n"),
        ("a:\n  b: 'on'\n", ("a", "b"), "1e3", 'a:\n  b: "1e3"\n'),
        ("a: 1", ("a",), 2, "a: 2\n"),
        ("a:\n  b: 1\n", ("a", "x"), None, "a:\n  b: 1\n"),
        ("a: [{b: 1}, {b: 2}]\n", ("a", 1, "b"), 3, "a: [{b: 1}, {b: 3}]\n"),
        ("a:\n  - {b: 1}  # x\n", ("a", 0, "c"), 3, "a:\n  - {b: 1, c: 3}  # x\n"),
        ("a:\n  - {b: 1, c: 3}\n  - 7\n", ("a", 0, "c"), None, "a:\n  - {b: 1}\n  - 7\n"),
        ("a:\n- b: 1\n- b: 2\nd: 1\n", ("a", 0, "c"), 3, "a:\n- b: 1\n  c: 3\n- b: 2\nd: 1\n"),
        ("a:\n  - b: 1\n    c: 2\n", ("a", 0, "b"), None, "a:\n  - c: 2\n"),
        ("a:\n  -\n    b: 1\n    c: 2\n", ("a", 0, "b"), None, "a:\n  -\n    c: 2\n"),
    ],
)
def test_the_text_stays_a_person_s(text: str, where: Location, value: Any, changed: str) -> None:
    assert with_values(text, {where: value}) == changed


@pytest.mark.parametrize(
    ("text", "where"),
    [("a: &x {b: 1}\nc: *x\n", ("a", "b")), ("a: &x 1\nc: *x\n", ("a",))],
)
def test_what_cannot_be_changed_rightly_is_refused(text: str, where: tuple[str, ...]) -> None:
    with pytest.raises(EditError, match=rf"{'.'.join(where)}: cannot be changed in this text"):
        with_values(text, {where: 7})


@pytest.mark.parametrize("where", [("a", 1, "b"), ("a", "b"), ("d", 0, "b"), ("e", 0, "b")])
def test_an_entry_that_is_not_there_is_not_made(where: Location) -> None:
    with pytest.raises(EditError, match="there is no such entry"):
        with_values("a: [{b: 1}]\nd: 1\n", {where: 7})


def test_a_text_of_several_lines_is_changed() -> None:
    assert read_document(with_values("a: |\n  one\n  two\nb: 1\n", {("a",): 7})).data == {
        "a": 7,
        "b": 1,
    }


@given(PLAIN)
def test_a_value_s_text_is_read_back_as_the_value(value: Any) -> None:
    assert read_document(f"a: {value_text(value)}").data == {"a": value}
