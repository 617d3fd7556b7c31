"""YAML with the place of every value, so that an error can point at its line and column.

Rules
- The scalars are those of YAML 1.2's core schema: ``1e-3`` is a number, ``on`` and ``no`` are
  words. PyYAML alone follows YAML 1.1.
- A duplicate key, a key that is not a word and an alias inside itself are errors.
- Length, depth and the number of values, with every alias written out, are bounded: nine lines of
  aliases of aliases would be a billion values.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, TypeAlias

import yaml

MOST_CHARACTERS: Final = 500_000
MOST_SHOWN: Final = 40
MOST_DEPTH: Final = 50
MOST_VALUES: Final = 20_000
"""A mission of a thousand stations has five thousand."""

Location: TypeAlias = tuple[str | int, ...]
"""Path to a value: ``("mission", "stations", 0, "x_m")``."""


@dataclass(frozen=True, slots=True)
class Mark:
    """A place in the text: line and column from 1, and number of characters to underline."""

    line: int
    column: int
    width: int = 1


@dataclass(frozen=True, slots=True)
class Defect:
    """An error of the YAML itself, and its place."""

    mark: Mark
    message: str


@dataclass(slots=True)
class Document:
    """A parsed text: plain data, marks of keys and values, and the YAML's defects."""

    text: str
    data: Any = None
    keys: dict[Location, Mark] = field(default_factory=dict)
    values: dict[Location, Mark] = field(default_factory=dict)
    defects: list[Defect] = field(default_factory=list)


class TooMuchError(yaml.YAMLError):
    """Error: a document beyond the bounds."""

    def __init__(self, message: str, mark: Mark) -> None:
        super().__init__(message)
        self.mark = mark


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader with YAML 1.2's scalars, and bounds."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self._depth = self._values = 0
        self._sizes: dict[int, int] = {}
        """Number of values in each node, aliases written out, by its identity."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        mark: yaml.Mark = self.peek_event().start_mark  # type: ignore[no-untyped-call]
        is_alias = self.check_event(yaml.AliasEvent)
        before = self._values
        self._depth += 1
        if self._depth > MOST_DEPTH:
            raise TooMuchError(f"is nested too deeply: more than {MOST_DEPTH} levels", _mark(mark))
        self._values += 1
        node: yaml.Node | None = super().compose_node(parent, index)
        self._depth -= 1
        if is_alias:
            self._values += self._sizes.get(id(node), 1) - 1
        else:
            self._sizes[id(node)] = self._values - before
        if self._values > MOST_VALUES:
            sentence = f"has more than {MOST_VALUES} values, with its aliases written out"
            raise TooMuchError(sentence, _mark(mark))
        return node


def compose(text: str) -> yaml.Node | None:
    """Node tree of a YAML text, None for an empty one.

    ``yaml.YAMLError``, or ``TooMuchError`` if it is longer, deeper or larger than any
    configuration.
    """
    if len(text) > MOST_CHARACTERS:
        raise TooMuchError(f"is longer than {MOST_CHARACTERS} characters", Mark(1, 1))
    node: yaml.Node | None = _Loader(text).get_single_node()
    return node


_TAG = "tag:yaml.org,2002:"
_CORE = (
    ("bool", r"true|True|TRUE|false|False|FALSE", "tTfF"),
    ("null", r"~|null|Null|NULL|", "~nN"),
    ("int", r"[-+]?[0-9]+|0x[0-9a-fA-F]+", "-+0123456789"),
    (
        "float",
        r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?|[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)",
        "-+.0123456789",
    ),
)
_Loader.yaml_implicit_resolvers = {}
for _name, _pattern, _first in _CORE:
    _Loader.add_implicit_resolver(
        _TAG + _name,
        re.compile(f"(?:{_pattern})$"),
        [*_first, ""] if _name == "null" else [*_first],
    )


def _bool(word: str) -> bool:
    if word.lower() not in ("true", "false"):
        raise ValueError
    return word.lower() == "true"


def _float(word: str) -> float:
    return float(word.lower().replace(".inf", "inf").replace(".nan", "nan"))


_CONSTRUCT: dict[str, Callable[[str], Any]] = {
    "str": str,
    "int": lambda word: int(word, 16 if "x" in word else 10),
    "float": _float,
    "bool": _bool,
    "null": lambda _: None,
}


def read_document(text: str) -> Document:
    """Parse YAML text; errors are listed in ``defects``, never raised."""
    document = Document(text)
    try:
        node = compose(text)
        if node is not None:
            document.data = _Walk(document).value(node, ())
    except TooMuchError as error:
        document.defects.append(Defect(error.mark, str(error)))
    except yaml.MarkedYAMLError as error:
        mark, message = _fault(error)
        document.defects.append(Defect(_mark(mark) if mark else Mark(1, 1), "not YAML: " + message))
    except yaml.reader.ReaderError as error:
        place = text[: error.position]
        mark_here = Mark(place.count("\n") + 1, len(place) - place.rfind("\n"))
        message = f"not YAML: the character {chr(error.character)!r} is not allowed"
        document.defects.append(Defect(mark_here, message))
    return document


def _fault(error: yaml.MarkedYAMLError) -> tuple[yaml.Mark | None, str]:
    """Place of an error and its sentence; our own for the two that people make most."""
    problem = error.problem or ""
    if problem.startswith(r"found character '\t'"):
        return error.problem_mark, "a tab: must be spaces"
    if problem == "could not find expected ':'" and error.context == "while scanning a simple key":
        # PyYAML notices it a line further on
        return error.context_mark, "must be `key: value`, with a space behind the colon"
    parts = (error.context, error.problem)
    return error.problem_mark or error.context_mark, ", ".join(part for part in parts if part)


def _mark(start: yaml.Mark, end: yaml.Mark | None = None) -> Mark:
    same_line = end is not None and end.line == start.line
    width = end.column - start.column if end is not None and same_line else 1
    return Mark(start.line + 1, start.column + 1, max(1, width))


class _Walk:
    def __init__(self, document: Document) -> None:
        self._document = document
        self._open: list[yaml.Node] = []

    def value(self, node: yaml.Node, at: Location) -> Any:
        document = self._document
        document.values[at] = _mark(node.start_mark, node.end_mark)
        if any(node is outer for outer in self._open):
            document.defects.append(Defect(_mark(node.start_mark), "an alias inside itself"))
            return None
        self._open.append(node)
        try:
            if isinstance(node, yaml.MappingNode):
                return self._mapping(node, at)
            if isinstance(node, yaml.SequenceNode):
                return [self.value(item, (*at, i)) for i, item in enumerate(node.value)]
            return self._scalar(node)
        finally:
            self._open.pop()

    def _mapping(self, node: yaml.MappingNode, at: Location) -> dict[str, Any]:
        result: dict[str, Any] = {}
        for key_node, value_node in node.value:
            mark = _mark(key_node.start_mark, key_node.end_mark)
            key = self._scalar(key_node) if isinstance(key_node, yaml.ScalarNode) else None
            if not isinstance(key, str):
                self._document.defects.append(Defect(mark, "a key must be a word"))
                continue
            if key in result:
                first = self._document.keys[(*at, key)].line
                message = f"the key '{key}' is here a second time, first in line {first}"
                self._document.defects.append(Defect(mark, message))
                continue
            self._document.keys[(*at, key)] = mark
            result[key] = self.value(value_node, (*at, key))
        return result

    def _scalar(self, node: yaml.Node) -> Any:
        kind = node.tag.removeprefix(_TAG)
        try:
            if kind in _CONSTRUCT:
                return _CONSTRUCT[kind](node.value)
            problem = f"the tag {node.tag.replace(_TAG, '!!')} has no meaning here"
        except ValueError:
            shown = node.value if len(node.value) <= MOST_SHOWN else node.value[:MOST_SHOWN] + "..."
            problem = f"'{shown}' is no {kind}"
        mark = _mark(node.start_mark, node.end_mark)
        self._document.defects.append(Defect(mark, problem))
        return None
