"""The configuration as a form: what each key means, may be, and is now, made from its schema.

Rules
- Changed here are numbers, switches, choices, and lists of numbers, and which of the devices that
  are plugged in is the camera and the robot's port. Everything else is shown only, with the
  reason: a file's name, an address or a command opens what the page's user may not open.
- ``safety`` and ``dashboard`` are shown only: who may reach the page does not decide what keeps
  the robot from harm, nor who else may come.
- What is typed is read as YAML's core schema reads it, so a form and a file mean the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from navigation.config.editing.in_text import Words, present_value, value_text
from navigation.config.marks import read_document
from navigation.config.reference import json_schema
from navigation.config.secrecy.secrets import SECRET_KEY
from navigation.config.sections import SIMULATED

SHOWN_SECTIONS: Final = {
    "safety": "what keeps the robot from harm is changed in the file",
    "dashboard": "who may reach this page is changed in the file",
}
DEVICE_KEYS: Final = {("camera", "source"): "cameras", ("serial", "port"): "ports"}
MOST_TYPED: Final = 500
_LIMITS: Final = {
    "exclusiveMinimum": "above",
    "minimum": "least",
    "exclusiveMaximum": "below",
    "maximum": "most",
}


class TypedError(ValueError):
    """What was typed cannot be a value of its key; the message says why."""


@dataclass(frozen=True, slots=True)
class Key:
    """One key of the form: its place, its schema, and why it is only shown ("": it can change)."""

    where: Words
    kind: str
    """``number``, ``whole``, ``flag``, ``choice``, ``list`` or ``text``."""
    schema: Mapping[str, Any]
    meaning: str
    only_shown: str

    @property
    def name(self) -> str:
        """As people write it: ``camera.rate_hz``."""
        return ".".join(self.where)

    def value_of(self, typed: str) -> Any:
        """What was typed as plain data, None for "as without the key"; ``TypedError``."""
        if len(typed) > MOST_TYPED:
            raise TypedError(f"{self.name}: more than {MOST_TYPED} characters")
        words = typed.strip()
        if not words:
            return None
        if self.kind == "list" and not words.startswith("["):
            words = f"[{words}]"
        document = read_document(words)
        if document.defects or isinstance(document.data, dict):
            raise TypedError(f"{self.name}: {typed!r} is no value")
        if self.kind == "choice" and document.data not in self.schema["enum"]:
            allowed = ", ".join(map(str, self.schema["enum"]))
            raise TypedError(f"{self.name}: must be one of {allowed}, not {words}")
        return document.data


def form_keys(cameras: Sequence[str] = (), ports: Sequence[str] = ()) -> Iterator[Key]:
    """Every key of a configuration, in the order of the reference; devices by their paths."""
    schema = json_schema()
    devices = {"cameras": cameras, "ports": ports}
    yield from _keys((), schema["properties"], schema["$defs"], devices)


def form(text: str, keys: Sequence[Key]) -> list[dict[str, Any]]:
    """The sections of the form for a configuration's text, as JSON takes them.

    A key's ``value`` is what its field shows, "" where the text does not have it; ``default`` is
    what holds then. Secret values are never told.
    """
    data = read_document(text).data
    meanings = {name: p.get("description", "") for name, p in json_schema()["properties"].items()}
    sections: dict[str, dict[str, Any]] = {}
    for key in keys:
        name = key.where[0]
        section = sections.setdefault(name, {"name": name, "meaning": meanings[name], "keys": []})
        present = present_value(data, key.where)
        section["keys"].append(_field(key, present))
    return list(sections.values())


def _field(key: Key, present: Any) -> dict[str, Any]:
    is_secret = SECRET_KEY.search(key.where[-1]) is not None
    default = key.schema.get("default")
    field: dict[str, Any] = {
        "key": key.name,
        "kind": key.kind,
        "meaning": key.meaning,
        "value": "(not shown)" if is_secret and present is not None else _shown(key, present),
        "default": _shown(key, default),
        "only_shown": key.only_shown,
    }
    if key.kind == "choice":
        choices = [str(value_text(choice)) for choice in key.schema["enum"]]
        value = field["value"]
        field["choices"] = choices if not value or value in choices else [value, *choices]
    limits = {word: key.schema[name] for name, word in _LIMITS.items() if name in key.schema}
    if limits and key.kind in ("number", "whole"):
        field["limits"] = limits
    return field


def _shown(key: Key, value: Any) -> str:
    if value is None:
        return ""
    told = value_text(value)
    return told[1:-1] if key.kind == "list" else told


def _keys(
    at: Words,
    properties: Mapping[str, Any],
    models: Mapping[str, Any],
    devices: Mapping[str, Sequence[str]],
) -> Iterator[Key]:
    for name, schema in properties.items():
        where = (*at, name)
        inner = _section_of(schema)
        if inner is not None:
            yield from _keys(where, models[inner]["properties"], models, devices)
        else:
            yield _key(where, schema, devices)


def _section_of(schema: Mapping[str, Any]) -> str | None:
    """The name of the section that a schema is, None of a value."""
    ways = [schema, *schema.get("anyOf", ())]
    found = next((way["$ref"] for way in ways if "$ref" in way), None)
    return None if found is None else str(found).rsplit("/", 1)[-1]


def _key(where: Words, whole: Mapping[str, Any], devices: Mapping[str, Sequence[str]]) -> Key:
    ways = [way for way in whole.get("anyOf", (whole,)) if way.get("type") != "null"]
    schema = {**ways[0], "default": whole.get("default")}
    kind, reason = _kind(where, ways, schema)
    if where in DEVICE_KEYS:
        schema["enum"] = [SIMULATED, *devices[DEVICE_KEYS[where]]]
        kind, reason = "choice", ""
    reason = SHOWN_SECTIONS.get(where[0], reason)
    return Key(where, kind, schema, whole.get("description", ""), reason)


def _kind(
    where: Words, ways: Sequence[Mapping[str, Any]], schema: Mapping[str, Any]
) -> tuple[str, str]:
    """What kind of field it is, and why it is only shown."""
    types = {way.get("type") for way in ways}
    if types == {"boolean"}:
        return "flag", ""
    if "enum" in schema and len(ways) == 1:
        return "choice", ""
    if types == {"integer"}:
        return "whole", ""
    if types == {"number"}:
        return "number", ""
    if types == {"number", "string"}:  # a number or one of a few words
        return "text", ""
    if types == {"array"} and "prefixItems" in schema:
        return "list", ""
    if types == {"array"}:
        return "list", "lists are changed in the file"
    return "text", "names of files, addresses and commands are changed in the file"
