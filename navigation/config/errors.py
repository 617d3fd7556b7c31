"""Problems of a configuration, reported together so that each can be corrected at once.

Each is ``file:line:column: key: what is wrong``, the line itself, a caret under the place and, if
it can be guessed, the intended word.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel

from navigation.config.marks import Document, Location, Mark
from navigation.config.secrecy.secret_places import masked
from navigation.config.secrecy.secrets import hide, is_secret_key

LONGEST_LINE = 100


@dataclass(frozen=True, slots=True)
class Problem:
    """A problem; its place is None for the environment."""

    where: Location
    message: str
    mark: Mark | None = None
    source: str = ""
    is_secret: bool = False
    """True if the value is never shown."""

    @property
    def key(self) -> str:
        """The written key: ``mission.stations[0].x_m``."""
        return key_name(self.where)


class ConfigError(ValueError):
    """A configuration cannot be used; ``problems`` holds every reason, the text all of them."""

    exit_code = 78

    def __init__(
        self,
        file: str,
        problems: Sequence[Problem],
        text: str = "",
        sound: Mapping[str, Any] | None = None,
        unknown: Sequence[tuple[int, int]] = (),
    ) -> None:
        self.file = file
        self.problems = tuple(problems)
        self.text = text
        self.sound = dict(sound or {})
        """Sections that can be trusted all the same."""
        self.unknown = tuple(unknown)
        """Positions of the values of unknown keys, which are never shown."""
        lines = masked(text, self.unknown).splitlines()
        told = [hide(_told(problem, file, lines)) for problem in self.problems]
        if len(told) > 1:
            told.insert(0, f"{file}: {len(told)} errors")
        super().__init__("\n".join(told))

    def with_advice(self, advice: str) -> ConfigError:
        """Add a hint at the end of its text."""
        self.args = (f"{self}\n{advice}",)
        return self


def key_name(where: Location) -> str:
    """Write ``("stations", 0, "x_m")`` as ``stations[0].x_m``."""
    name = ""
    for part in where:
        name += f"[{part}]" if isinstance(part, int) else f".{part}"
    return name.lstrip(".")


def _told(problem: Problem, file: str, lines: Sequence[str]) -> str:
    what = f"{problem.key}: {problem.message}" if problem.where else problem.message
    mark = problem.mark
    if problem.source or mark is None:
        return f"{problem.source or file}: {what}"
    told = f"{file}:{mark.line}:{mark.column}: {what}"
    if problem.is_secret or mark.line > len(lines):
        return told
    line = lines[mark.line - 1]
    shown, before = _around(line.replace("\t", " "), mark.column - 1)
    width = max(1, min(mark.width, len(line) - mark.column + 1, len(shown) - before))
    return f"{told}\n    {shown}\n    {' ' * before}^{'~' * (width - 1)}"


def _around(line: str, place: int) -> tuple[str, int]:
    if len(line) <= LONGEST_LINE:
        return line, place
    begin = min(max(0, place - LONGEST_LINE // 3), max(0, len(line) - LONGEST_LINE))
    end = begin + LONGEST_LINE
    head, tail = ("..." if begin > 0 else ""), ("..." if end < len(line) else "")
    return f"{head}{line[begin:end]}{tail}", place - begin + len(head)


def mark_of(document: Document, where: Location, *, of_key: bool = False) -> Mark | None:
    """Place of a value, or of the nearest thing around it in the text."""
    if of_key and where in document.keys:
        return document.keys[where]
    while where and where not in document.values:
        where = where[:-1]
        if where in document.keys:
            return document.keys[where]
    return document.values.get(where)


def problems_of(
    errors: Iterable[Any], document: Document, model: type[BaseModel]
) -> Iterator[Problem]:
    """Yield pydantic's error details as problems; a misspelt key appears once."""
    errors = list(errors)
    unknown = [tuple(e["loc"]) for e in errors if e["type"] == "extra_forbidden"]
    missing = [tuple(e["loc"]) for e in errors if e["type"] == "missing"]
    for error in errors:
        where: Location = tuple(error["loc"])
        kind = error["type"]
        if kind == "extra_forbidden":
            yield Problem(where, _unknown(where, model), mark_of(document, where, of_key=True))
        elif kind == "missing":
            if not _is_misspelt(where, unknown, missing):
                mark = mark_of(document, where[:-1], of_key=True)
                yield Problem(where, "is missing" + _meaning(where, model), mark)
        else:
            secret = any(is_secret_key(str(part)) for part in where)
            sentence = _sentence(error, "the value there" if secret else None)
            yield Problem(where, sentence, mark_of(document, where), is_secret=secret)


def _is_misspelt(where: Location, unknown: list[Location], missing: list[Location]) -> bool:
    """True if an unknown key of the same section will be reported as this missing one."""
    near = [str(u[-1]) for u in unknown if u[:-1] == where[:-1]]
    mates = [str(m[-1]) for m in missing if m[:-1] == where[:-1]]
    return any(difflib.get_close_matches(key, mates, n=1) == [where[-1]] for key in near)


def fields_at(where: Location, model: type[BaseModel]) -> type[BaseModel] | None:
    """Model of the section at ``where``, if any."""
    here: type[BaseModel] | None = model
    for part in where:
        if isinstance(part, int):
            continue
        if here is None or part not in here.model_fields:
            return None
        here = model_in(here.model_fields[part].annotation)
    return here


def model_in(annotation: Any) -> type[BaseModel] | None:
    """Model inside an annotation such as ``Model | None`` or ``tuple[Model, ...]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        found = model_in(inner)
        if found is not None:
            return found
    return None


def _unknown(where: Location, model: type[BaseModel]) -> str:
    section = fields_at(where[:-1], model)
    known = list(section.model_fields) if section else []
    near = difflib.get_close_matches(str(where[-1]), known, n=1)
    if near:
        return f"unknown key; did you mean '{near[0]}'?"
    elsewhere = _home_of(str(where[-1]), model)
    if elsewhere:
        return f"unknown key here; did you mean '{elsewhere}'?"
    return f"unknown key; the keys here are {', '.join(known)}"


def _home_of(key: str, model: type[BaseModel]) -> str | None:
    """Place where a key belongs; in a section rather than in a list's entries."""
    fields = sorted(model.model_fields.items(), key=lambda item: "tuple" in str(item[1].annotation))
    for name, field in fields:
        if key == name:
            return name
        section = model_in(field.annotation)
        if section is not None:
            inner = _home_of(key, section)
            if inner is not None:
                return f"{name}.{inner}"
    return None


def _meaning(where: Location, model: type[BaseModel]) -> str:
    section = fields_at(where[:-1], model)
    field = section.model_fields.get(str(where[-1])) if section else None
    return f": {field.description}" if field and field.description else ""


_LIMIT_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
_KINDS = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "bool_type": "true or false",
    "string_type": "text",
    "path_type": "a file name",
    "tuple_type": "a list",
    "list_type": "a list",
    "model_type": "a section of its own (key: value lines)",
    "model_attributes_type": "a section of its own (key: value lines)",
    "finite_number": "a finite number",
}


def _sentence(error: Any, instead: str | None = None) -> str:
    kind, context = error["type"], error.get("ctx", {})
    given = instead or _given(error["input"])
    if kind in _KINDS:
        return f"must be {_KINDS[kind]}, not {given}"
    if kind == "literal_error":
        words = re.findall(r"'([^']*)'", context["expected"])
        near = difflib.get_close_matches(str(error["input"]), words, n=1)
        hint = f"; did you mean '{near[0]}'?" if near else ""
        return f"must be {context['expected']}, not {given}{hint}"
    for name, sign in _LIMIT_SIGNS.items():
        if name in context:
            return f"must be {sign} {context[name]:g}, not {given}"
    if kind in ("too_long", "too_short"):
        wanted = context.get("max_length", context.get("min_length"))
        bound = "at most" if kind == "too_long" else "at least"
        return f"must have {bound} {wanted} entries, not {context['actual_length']}"
    if kind == "value_error":
        return str(context["error"])
    message = str(error["msg"])
    return f"{message[:1].lower()}{message[1:]}, not {given}"


def _given(value: Any) -> str:
    if value is None:
        return "empty"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, dict):
        return "a section"
    if isinstance(value, list):
        return "a list"
    try:
        shown = repr(value)
    except ValueError:  # an integer of thousands of digits has no decimal form
        return "a number of thousands of digits"
    return shown if len(shown) <= 60 else shown[:57] + "..."


def in_order(problems: list[Problem]) -> list[Problem]:
    """Sort problems by their place in the file."""
    return sorted(problems, key=lambda p: (p.mark.line, p.mark.column) if p.mark else (0, 0))
