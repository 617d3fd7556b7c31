"""The borders of a run: what others read of it has the shape and the words of the golden files."""

from __future__ import annotations

import json

import pytest

from tests.support.runs.boundaries import FILES, GOLDEN, seen_of, shape

COMMAND = "python -m tests.support.runs.boundaries"


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_what_others_read_of_a_run_has_the_shape_and_the_words_that_it_had(name: str) -> None:
    golden = json.loads((GOLDEN / name).read_text(encoding="utf-8"))
    seen = seen_of(FILES[name]())
    assert seen.keys() == golden.keys()
    for part, value in golden.items():
        assert seen[part] == value, f"{part} is another: if it is meant to be, run {COMMAND}"


def test_a_shape_keeps_words_and_leaves_numbers_out() -> None:
    assert shape({"a": 1, "b": [0.5, 2], "c": True, "d": None}) == {
        "a": "number", "b": ["number"], "c": True, "d": None
    }  # fmt: skip
    assert shape("12.5 mm from (-1, 2) at 2026-11-25T16:33:25.453Z") == "# mm from (#, #) at time"
    assert shape("READY=1") == "READY=1"
    assert shape("clearway.status/1") == "clearway.status/1"
    assert shape([{"x": 1}, {"x": 2}]) == [{"x": "number"}]
    assert shape([{"x": 1}, {"y": 2}]) == [{"x": "number"}, {"y": "number"}]
