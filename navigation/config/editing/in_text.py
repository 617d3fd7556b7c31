"""Puts values into a configuration's text: comments, order and the other keys stay.

Rules
- A value is written as JSON, a part of YAML; words have no quotes where YAML allows it.
- The result is read again and compared with the intended data. A text that cannot be changed
  rightly (anchors, block scalars, lists on their own lines) is refused, never spoilt.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Mapping
from typing import Any, Final

import yaml

from navigation.config.errors import key_name
from navigation.config.marks import Location, compose, read_document

COMMENT_COLUMN: Final = 40
_PLAIN: Final = re.compile(r"[A-Za-z_./][\w./:-]*")


class EditError(ValueError):
    """Error: a value cannot be put into this text."""


def with_values(text: str, changes: Mapping[Location, Any]) -> str:
    """Text with these values at their keys; ``EditError`` if that cannot be done.

    ``text`` is sound YAML; values are plain data, None for "no key". A number in a place is that of
    an existing entry, from 0.
    """
    wanted = read_document(text).data
    if not isinstance(wanted, dict):
        raise EditError("the configuration is no text of sections; correct it in the file")
    wanted = copy.deepcopy(wanted)
    changed = text if text.endswith("\n") else text + "\n"
    for where, value in changes.items():
        _find_entries(wanted, where)
        changed = _with_value(changed, where, value)
        _put(wanted, where, value)
    got = read_document(changed)
    if got.defects or not _is_same(got.data, wanted):
        names = ", ".join(map(key_name, changes))
        raise EditError(f"{names}: cannot be changed in this text without harm; edit the file")
    return changed


def _find_entries(data: Any, where: Location) -> None:
    for length, key in enumerate(where, 1):
        if isinstance(key, int) and present_value(data, where[:length]) is None:
            raise EditError(f"{key_name(where)}: there is no such entry in this text")


def value_text(value: Any) -> str:
    """Write a value as YAML's core schema reads it back."""
    if isinstance(value, str) and _PLAIN.fullmatch(value) and read_document(value).data == value:
        return value
    if isinstance(value, float) and value.is_integer() and abs(value) < 2**53:
        return str(int(value))
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key}: {value_text(item)}" for key, item in value.items()) + "}"
    if isinstance(value, str):
        quoted: str = yaml.safe_dump(
            value, default_style='"', allow_unicode=True, width=len(value) * 10 + 10
        )
        return quoted.rstrip("\n")
    return json.dumps(value)


def _with_value(text: str, where: Location, value: Any) -> str:
    """Make one change; the deepest existing mapping takes the rest as its own key."""
    node = compose(text)
    for depth, key in enumerate(where):
        if isinstance(node, yaml.SequenceNode) and isinstance(key, int) and key < len(node.value):
            node = node.value[key]
            continue
        if not (isinstance(node, yaml.MappingNode) and isinstance(key, str)):
            raise EditError(f"{key_name(where)}: there is no such entry in this text")
        entry = _entry(node, key)
        if entry is None:
            return text if value is None else _added(text, node, where[depth:], value)
        name, held = entry
        if depth == len(where) - 1:
            if value is None:
                return _removed(text, node, name, held)
            return _replaced(text, name, held, value)
        if not isinstance(held, yaml.CollectionNode):
            rest = _nested(where[depth + 1 :], value)
            return text if value is None else _replaced(text, name, held, rest)
        node = held
    return text


def _entry(node: yaml.MappingNode, key: str) -> tuple[yaml.Node, yaml.Node] | None:
    return next((pair for pair in node.value if pair[0].value == key), None)


def _end_of(node: yaml.Node) -> int:
    """End of a node's own text; PyYAML extends a block past the comments behind it."""
    if not isinstance(node, yaml.CollectionNode) or node.flow_style or not node.value:
        return int(node.end_mark.index)
    last = node.value[-1]
    parts = last if isinstance(last, tuple) else (last,)
    return max(_end_of(part) for part in parts)


def _nested(where: Location, value: Any) -> Any:
    for key in reversed(where):
        value = {key: value}
    return value


def _replaced(text: str, name: yaml.Node, held: yaml.Node, value: Any) -> str:
    """Replace a key's value; a comment beside it keeps its column if possible."""
    begin, end = held.start_mark.index, _end_of(held)
    if begin == end:  # the key had no value
        begin = end = text.index(":", name.end_mark.index) + 1
        return f"{text[:begin]} {value_text(value)}{text[end:]}"
    while text[end - 1] in "\n ":  # a text of several lines includes the last line's end
        end -= 1
    told = value_text(value)
    gap = re.match(r" +(?=#)", text[end:])
    if gap is None:
        return f"{text[:begin]}{told}{text[end:]}"
    line = begin - (text.rfind("\n", 0, begin) + 1)
    before = line + (end - begin) + len(gap.group())
    space = " " * max(2, before - line - len(told))
    return f"{text[:begin]}{told}{space}{text[end + len(gap.group()) :]}"


def _added(text: str, node: yaml.MappingNode, where: Location, value: Any) -> str:
    if node.flow_style:
        inside = node.end_mark.index - 1
        comma = ", " if node.value else ""
        pair = f"{where[0]}: {value_text(_nested(where[1:], value))}"
        return f"{text[:inside].rstrip()}{comma}{pair}{text[inside:]}"
    if node.start_mark.column == 0 and len(where) > 1:  # a section of its own
        line = f"{where[1]}: {value_text(_nested(where[2:], value))}"
        return f"{text.rstrip()}\n\n{where[0]}:\n  {line}\n"
    at = _end_of(node)
    while text[at - 1] in "\n ":
        at -= 1
    end = text.find("\n", at)
    indent = " " * node.value[0][0].start_mark.column
    pair = f"{where[0]}: {value_text(_nested(where[1:], value))}"
    return f"{text[:end]}\n{indent}{pair}{text[end:]}"


def _removed(text: str, node: yaml.MappingNode, name: yaml.Node, held: yaml.Node) -> str:
    """Remove a key; a mapping that loses its last one stays, empty."""
    if len(node.value) == 1:
        return (
            f"{text[: node.start_mark.index]}{{}}{text[node.end_mark.index :]}"
            if (node.flow_style)
            else _emptied(text, node)
        )
    end = max(_end_of(held), name.end_mark.index)
    number = [pair[0] for pair in node.value].index(name)
    is_behind_a_dash = number == 0 and _begins_entry(text, name)
    if (node.flow_style or is_behind_a_dash) and number + 1 < len(node.value):
        return text[: name.start_mark.index] + text[node.value[number + 1][0].start_mark.index :]
    if node.flow_style:
        return text[: _end_of(node.value[number - 1][1])] + text[end:]
    while text[end - 1] in "\n ":
        end -= 1
    begin = text.rfind("\n", 0, name.start_mark.index) + 1
    return text[:begin] + text[text.find("\n", end) + 1 :]


def _begins_entry(text: str, name: yaml.Node) -> bool:
    """True if a key is on the line of its entry's dash, which has to stay."""
    begin = text.rfind("\n", 0, name.start_mark.index) + 1
    return text[begin : name.start_mark.index].strip() == "-"


def _emptied(text: str, node: yaml.MappingNode) -> str:
    begin = text.rfind("\n", 0, node.start_mark.index) + 1
    end = _end_of(node)
    while text[end - 1] in "\n ":
        end -= 1
    line_end = text.find("\n", end) + 1
    colon = text.rfind(":", 0, begin)
    return f"{text[: colon + 1]} {{}}{text[colon + 1 : begin]}{text[line_end:]}"


def _put(data: Any, where: Location, value: Any) -> None:
    *outer, last = where
    for key in outer:
        inner = data[key] if isinstance(key, int) else data.get(key)
        if not isinstance(inner, dict | list):
            if value is None:
                return
            inner = data[key] = {}
        data = inner
    if value is None:
        data.pop(last, None)
    else:
        data[last] = value


def _is_same(got: Any, wanted: Any) -> bool:
    """True if equal as data: 1 and 1.0 are one number, True is not a number."""
    if isinstance(got, dict) and isinstance(wanted, dict):
        return got.keys() == wanted.keys() and all(_is_same(got[k], wanted[k]) for k in got)
    if isinstance(got, list) and isinstance(wanted, list | tuple):
        return len(got) == len(wanted) and all(map(_is_same, got, wanted))
    return isinstance(got, bool) is isinstance(wanted, bool) and bool(got == wanted)


def present_value(data: Any, where: Location) -> Any:
    """Value in the data at a key, if present."""
    for key in where:
        if isinstance(key, int):
            data = data[key] if isinstance(data, list) and key < len(data) else None
        else:
            data = data.get(key) if isinstance(data, dict) else None
    return data
