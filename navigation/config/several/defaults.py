"""The sections `robot`, `serial` and `camera` as defaults of several robots and cameras.

A default that every entry overrides is never used, so it is neither required nor checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

from navigation.config.marks import Location

_ENTRIES: Final = {"robot": "robots", "serial": "robots", "camera": "cameras"}
"""By the section: the list whose entries override it."""


def is_overridden(sections: Mapping[str, Any], where: Location) -> bool:
    """True if ``where`` is a default's key, and each of several entries has its own value."""
    if len(where) != 2 or where[0] not in _ENTRIES:
        return False
    entries = sections.get(_ENTRIES[str(where[0])], ())
    return bool(entries) and all(getattr(e, str(where[1]), None) is not None for e in entries)


def with_source_of_cameras(data: Any) -> Any:
    """The data with the first camera's source as the default where every camera names its own."""
    cameras = data.get("cameras")
    camera = data.get("camera", {})
    if not isinstance(cameras, list) or not cameras or not isinstance(camera, dict):
        return data
    if not all(isinstance(one, dict) and one.get("source") is not None for one in cameras):
        return data
    return {**data, "camera": {"source": cameras[0]["source"], **camera}}
