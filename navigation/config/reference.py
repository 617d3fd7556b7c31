"""The configuration's reference and first file, made from the sections' descriptions."""

from __future__ import annotations

import json
import re
import textwrap
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from navigation.config.errors import model_in
from navigation.config.marks import read_document
from navigation.config.sections import Config
from navigation.config.several.defaults import without_overridden

_PLAIN = re.compile(r"[\w./-]+")
"""Words that need no quotes, unless YAML takes them for a number or the like."""
COMMENT_COLUMN = 42
LINE_WIDTH = 100


def json_schema() -> dict[str, Any]:
    """JSON Schema of a configuration, for editors."""
    schema = without_overridden(Config.model_json_schema())
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def reference_markdown() -> str:
    """The page docs/configuration.md."""
    schema = json_schema()
    lines = [
        "# Configuration",
        "",
        "Made by `clearway schema --format markdown`. Lengths are metres, times seconds, angles",
        "degrees; x points right, y up, headings turn counter-clockwise from +x. Unknown keys are",
        "errors. Relative file names are meant from the configuration's folder. A variable such as",
        "`CLEARWAY_SERIAL__PORT=/dev/ttyUSB0` in the environment overrides `serial.port`.",
    ]
    for name, field in Config.model_fields.items():
        lines += _section_markdown(name, field, schema, level=2)
    return "\n".join(lines) + "\n"


def starter_yaml(values: Mapping[str, Any], heading: str) -> str:
    """A commented configuration with ``values`` and every other key at its default.

    A key without a value is a comment. The result loads if ``values`` has every required key.
    """
    lines = [f"# {line}".rstrip() for line in heading.splitlines()]
    for name, field in Config.model_fields.items():
        lines += ["", *_starter_field(name, field, values, "")]
    return "\n".join(lines) + "\n"


def _section_markdown(
    name: str, field: FieldInfo, schema: Mapping[str, Any], level: int
) -> Iterator[str]:
    model = model_in(field.annotation)
    assert model is not None
    needed = " Required." if field.is_required() else ""
    many = " A list." if "tuple" in str(field.annotation) else ""
    yield from ("", f"{'#' * level} {name}", "", f"{_sentence(field)}{many}{needed}")
    yield from ("", "| key | type | default | meaning |", "|---|---|---|---|")
    properties = schema["$defs"][model.__name__]["properties"]
    inner: list[tuple[str, FieldInfo]] = []
    for key, part in model.model_fields.items():
        if model_in(part.annotation) is not None:
            inner.append((f"{name}.{key}", part))
        kind = _kind(properties[key], schema)
        default = "required" if part.is_required() else _default_words(part)
        yield f"| `{key}` | {kind} | {default} | {part.description} |"
    for full_name, part in inner:
        yield from _section_markdown(full_name, part, schema, level + 1)


def _sentence(field: FieldInfo) -> str:
    text = field.description or ""
    return f"{text[:1].upper()}{text[1:]}."


def _default_words(field: FieldInfo) -> str:
    value = field.default
    if isinstance(value, BaseModel):
        return "its own"
    return "empty" if value in (None, "", ()) else f"`{_yaml(value)}`"


_LIMITS = {
    "exclusiveMinimum": ">",
    "minimum": ">=",
    "exclusiveMaximum": "<",
    "maximum": "<=",
}


def _kind(schema: Mapping[str, Any], root: Mapping[str, Any]) -> str:
    if "anyOf" in schema:
        return " or ".join(_kind(one, root) for one in schema["anyOf"] if one != {"type": "null"})
    if "enum" in schema:
        words = schema["enum"]
        return ", ".join(f"`{word}`" for word in words) if len(words) < 6 else "one of the schema's"
    if "const" in schema:
        return f"`{schema['const']}`"
    if "$ref" in schema or schema.get("type") == "object":
        return "section"
    kind = schema.get("type", "")
    if kind == "array":
        items = schema.get("prefixItems", [])
        if items:
            return f"list of {len(items)} numbers"
        if schema["items"].get("type") == "array":
            return f"list of {_kind(schema['items'], root).replace('list', 'lists', 1)}"
        return "list of texts" if schema["items"].get("type") == "string" else "list of sections"
    words = {"string": "text", "boolean": "true or false", "integer": "whole number"}
    limits = [f"{sign} {schema[key]:g}" for key, sign in _LIMITS.items() if key in schema]
    return " ".join([words.get(kind, kind), *limits])


def _starter_field(
    name: str, field: FieldInfo, values: Mapping[str, Any], indent: str
) -> Iterator[str]:
    value = values.get(name)
    model = model_in(field.annotation)
    if model is None:
        yield from _starter_value(name, field, value, indent)
    elif isinstance(value, list | tuple):
        yield from _commented(f"{indent}{name}:", field)
        yield from (f"{indent}  - {_yaml(item)}" for item in value)
    elif field.is_required() or value is not None or isinstance(field.default, BaseModel):
        yield from _commented(f"{indent}{name}:", field)
        for key, part in model.model_fields.items():
            yield from _starter_field(key, part, value or {}, indent + "  ")
    else:
        yield from _commented(f"# {indent}{name}:", field)
        if "tuple" in str(field.annotation):
            for number, (key, part) in enumerate(model.model_fields.items()):
                yield from _commented(f"# {indent}  {' ' if number else '-'} {key}:", part)


def _starter_value(name: str, field: FieldInfo, value: Any, indent: str) -> Iterator[str]:
    if value is None and not field.is_required():
        value = field.get_default()
    if isinstance(value, str) and "\n" in value:
        yield from _commented(f"{indent}{name}: |", field)
        yield from (f"{indent}  {line}".rstrip() for line in value.splitlines())
    elif value is None:
        yield from _commented(f"{indent}# {name}:", field)
    else:
        yield from _commented(f"{indent}{name}: {_yaml(value)}", field)


def _commented(line: str, field: FieldInfo) -> Iterator[str]:
    beside = f"{line:<{COMMENT_COLUMN}}  # {field.description}"
    if len(beside) <= LINE_WIDTH:
        yield beside
        return
    indent = line[: len(line) - len(line.lstrip())]
    if line.startswith("# "):  # a key commented out keeps its own indentation
        key = line[2:]
        indent = "# " + key[: len(key) - len(key.lstrip())]
    yield from textwrap.wrap(
        field.description or "", LINE_WIDTH, initial_indent=f"{indent}# ",
        subsequent_indent=f"{indent}# ", break_on_hyphens=False,
    )  # fmt: skip
    yield line


def _yaml(value: Any) -> str:
    if isinstance(value, Path):
        value = str(value)
    if isinstance(value, str) and _PLAIN.fullmatch(value) and read_document(value).data == value:
        return value
    if isinstance(value, Mapping):
        inner = ", ".join(f"{key}: {_yaml(item)}" for key, item in value.items())
        return f"{{{inner}}}"
    return json.dumps(value, ensure_ascii=False)
