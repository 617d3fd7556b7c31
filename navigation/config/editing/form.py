"""The configuration as a form: each key's meaning, limits and present value, from its schema.

Rules
- Numbers, switches, choices, lists of numbers, and the plugged-in camera and port can be changed.
  The rest is only shown: a file's name, an address or a command opens things that the page's user
  may not open.
- ``safety``, ``dashboard`` and ``notify`` are only shown: the page's users decide neither on the
  robot's protection, nor on who may come, nor on what this program calls.
- Typed text is read by YAML's core schema, so a form and a file mean the same.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from navigation.config.editing.in_text import present_value, value_text
from navigation.config.errors import key_name
from navigation.config.marks import Location, read_document
from navigation.config.reference import json_schema
from navigation.config.secrecy.secrets import is_secret_key
from navigation.config.sections import RobotEntry, RobotSection, SerialSection
from navigation.config.values import SIMULATED
from navigation.shared.outside import printable

SHOWN_SECTIONS: Final = {
    "safety": "what keeps the robot from harm is changed in the file",
    "dashboard": "who may reach this page is changed in the file",
    "notify": "what this program runs or calls is changed in the file",
}
DEVICE_KEYS: Final = {
    ("camera", "source"): "cameras",
    ("serial", "port"): "ports",
    ("robots", "port"): "ports",
}
"""They name a device."""
ROBOTS: Final = "robots"
NAME: Final = (ROBOTS, "name")
MOST_TYPED: Final = 500
MOST_SAID: Final = 40
"""Characters of typed text in an error."""
_LIMITS: Final = {
    "exclusiveMinimum": "above",
    "minimum": "least",
    "exclusiveMaximum": "below",
    "maximum": "most",
}


class TypedError(ValueError):
    """Error: typed text cannot be a value of its key."""


@dataclass(frozen=True, slots=True)
class Key:
    """A key of the form; ``only_shown``: why it cannot change, or ""."""

    where: Location
    kind: str
    """``number``, ``whole``, ``flag``, ``choice``, ``list`` or ``text``."""
    schema: Mapping[str, Any]
    meaning: str
    only_shown: str

    @property
    def name(self) -> str:
        """The written name: ``camera.rate_hz``."""
        return key_name(self.where)

    @property
    def section(self) -> Location:
        """The section that holds it; an entry of a list is one, too."""
        return self.where[: 1 if self.entry is None else 2]

    @property
    def entry(self) -> int | None:
        """Number of its list entry, from 0; None outside lists."""
        number = self.where[1] if len(self.where) > 1 else None
        return number if isinstance(number, int) else None

    def value_of(self, typed: str) -> Any:
        """Parse typed text into plain data, None for "as without the key"; ``TypedError``."""
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
            raise TypedError(
                f"{self.name}: must be one of {allowed}, not {printable(words, MOST_SAID)}"
            )
        return document.data


def form_keys(text: str, cameras: Sequence[str] = (), ports: Sequence[str] = ()) -> Iterator[Key]:
    """Yield the keys of a configuration and of its robots; devices are given by their paths."""
    schema, data = json_schema(), read_document(text).data
    models = schema["$defs"]
    devices = {"cameras": cameras, "ports": ports}
    robots = present_value(data, (ROBOTS,))
    for name, whole in schema["properties"].items():
        if name == ROBOTS and isinstance(robots, list) and robots:
            entry = models[_section_of(whole["items"])]["properties"]
            for number in range(len(robots)):
                yield from _keys((ROBOTS, number), entry, models, devices)
        else:
            yield from _keys((), {name: whole}, models, devices)


def form(text: str, keys: Sequence[Key]) -> list[dict[str, Any]]:
    """Sections of the form for a configuration's text, as JSON data.

    A key's ``value`` is "" if the text lacks it; ``default`` then applies. Secrets are never shown.
    """
    data = read_document(text).data
    meanings = {name: p.get("description", "") for name, p in json_schema()["properties"].items()}
    sections: dict[Location, dict[str, Any]] = {}
    for key in keys:
        name = str(key.where[0])
        title, meaning = name, meanings[name]
        if key.entry is not None:
            title = f"{name}: {present_value(data, (name, key.entry, 'name'))}"
            meaning = "an empty field is as in `robot` and `serial`"
        several = key.entry is not None
        new = {"name": title, "meaning": meaning, "of_several": several, "keys": []}
        section = sections.setdefault(key.section, new)
        section["keys"].append(_field(key, data))
    return list(sections.values())


def _default_of(key: Key, data: Any) -> Any:
    """Value without the key: for one of several robots, the value common to all."""
    if key.entry is None:
        return key.schema.get("default")
    own = str(key.where[-1])
    if RobotEntry.model_fields[own].is_required():
        return None
    for section, model in (("robot", RobotSection), ("serial", SerialSection)):
        if own in model.model_fields:
            present = present_value(data, (section, own))
            default = model.model_fields[own].get_default()
            return default if present is None else present
    return None


def _field(key: Key, data: Any) -> dict[str, Any]:
    present, default = present_value(data, key.where), _default_of(key, data)
    is_secret = is_secret_key(str(key.where[-1]))
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
    at: Location,
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
    ways = [schema, *schema.get("anyOf", ())]
    found = next((way["$ref"] for way in ways if "$ref" in way), None)
    return None if found is None else str(found).rsplit("/", 1)[-1]


def _key(where: Location, whole: Mapping[str, Any], devices: Mapping[str, Sequence[str]]) -> Key:
    ways = [way for way in whole.get("anyOf", (whole,)) if way.get("type") != "null"]
    schema = {**ways[0], "default": whole.get("default")}
    kind, reason = _kind(where, ways, schema)
    kept = tuple(part for part in where if isinstance(part, str))
    if kept in DEVICE_KEYS:
        schema["enum"] = [SIMULATED, *devices[DEVICE_KEYS[kept]]]
        kind, reason = "choice", ""
    if kept == NAME:
        reason = "names are changed in the file, where missions and starts go by them"
    reason = SHOWN_SECTIONS.get(kept[0], reason)
    return Key(where, kind, schema, whole.get("description", ""), reason)


def _kind(
    where: Location, ways: Sequence[Mapping[str, Any]], schema: Mapping[str, Any]
) -> tuple[str, str]:
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
