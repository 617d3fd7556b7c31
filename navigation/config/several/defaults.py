"""The sections `robot`, `serial` and `camera` as defaults of several robots and cameras.

A default that every entry overrides is never used, so it is neither required nor checked.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final

from navigation.config.marks import Location
from navigation.config.values import with_own

_ENTRIES: Final = {"robot": "robots", "serial": "robots", "camera": "cameras"}


def is_overridden(sections: Mapping[str, Any], where: Location) -> bool:
    """True if ``where`` is a default's key, and each of several entries has its own value."""
    if len(where) != 2 or where[0] not in _ENTRIES:
        return False
    entries = sections.get(_ENTRIES[str(where[0])], ())
    return bool(entries) and all(getattr(e, str(where[1]), None) is not None for e in entries)


def found_in(
    sections: Mapping[str, Any],
    needed: Sequence[str],
    check: Callable[..., Iterator[tuple[Location, str]]],
) -> Iterator[tuple[Location, str]]:
    """Yield a check's findings in its sections: with several robots, in each one's own."""
    by_robot = "robots" not in needed and not {"robot", "serial"}.isdisjoint(needed)
    if not by_robot or not sections.get("robots"):
        yield from check(*(sections[name] for name in needed))
        return
    names: dict[tuple[Location, str], list[str]] = {}
    for index, entry in enumerate(sections["robots"]):
        own = dict(sections)
        own |= {key: with_own(own[key], entry) for key in ("robot", "serial") if key in own}
        for where, sentence in check(*(own[name] for name in needed)):
            if _ENTRIES.get(str(where[0])) == "robots" and len(where) == 2:
                key = str(where[1])
                where = ("robots", index, key) if getattr(entry, key, None) is not None else where
            names.setdefault((where, sentence), []).append(entry.name)
    for (where, sentence), whose in names.items():
        of_all = where[0] == "robots" or len(whose) == len(sections["robots"])
        yield where, sentence if of_all else f"for {', '.join(whose)}: {sentence}"


def without_overridden(schema: dict[str, Any]) -> dict[str, Any]:
    """JSON Schema of a configuration in which cameras that each name a source need no default."""
    camera = schema["$defs"]["CameraSection"]
    own_source = {"required": ["source"], "properties": {"source": {"type": ["integer", "string"]}}}
    one = {"required": ["camera"], "properties": {"camera": {"required": ["source"]}}}
    list_of_them = {"cameras": {"minItems": 1, "items": own_source}}
    several = {"required": ["cameras"], "properties": list_of_them}
    return {
        **_not_requiring(schema, "camera"),
        "$defs": {**schema["$defs"], "CameraSection": _not_requiring(camera, "source")},
        "anyOf": [one, several],
    }


def _not_requiring(schema: dict[str, Any], key: str) -> dict[str, Any]:
    return {**schema, "required": [name for name in schema["required"] if name != key]}


def with_source_of_cameras(data: Any) -> Any:
    """Use the first camera's source as the default if every camera names its own."""
    cameras = data.get("cameras")
    camera = data.get("camera", {})
    if not isinstance(cameras, list) or not cameras or not isinstance(camera, dict):
        return data
    if not all(isinstance(one, dict) and one.get("source") is not None for one in cameras):
        return data
    return {**data, "camera": {"source": cameras[0]["source"], **camera}}
