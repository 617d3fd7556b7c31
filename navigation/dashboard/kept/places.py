"""Named places, kept in a file beside the journal: operators save, rename and remove them.

Rules
- A name is unique, ignoring case; each place lies in the arena.
- The file is written whole before a change counts. An unreadable one is left alone: nothing can be
  saved then, and the sentence says why.

Metres, radians.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

from navigation.config.recording import RecordingSection
from navigation.orders.arguments import read_stations
from navigation.orders.errors import ControlError
from navigation.shared.outside import OutsideError, in_short, read_object
from navigation.shared.whole_file import UnwrittenFileError, write_whole
from planner.scene import Bounds

SCHEMA: Final = "clearway.places/1"
NAME_CHARACTERS: Final = 40
MOST_PLACES: Final = 200
MOST_BYTES: Final = 1_000_000


@dataclass(frozen=True, slots=True)
class SavedPlace:
    """A place by its name; ``heading_rad`` None: any heading."""

    name: str
    x_m: float
    y_m: float
    heading_rad: float | None


class PlaceError(ValueError):
    """Error: an impossible change of the places."""


class SavedPlaces:
    """The places of one file; one thread at a time may call `change`."""

    def __init__(self, path: Path, arena: Bounds) -> None:
        self.path, self._arena = path, arena
        self.places: tuple[SavedPlace, ...] = ()
        self.trouble = ""
        """Reason why nothing can be saved."""
        try:
            self.places = self._read()
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) and error.strerror else error
            self.trouble = f"{path}: the saved places cannot be read: {reason}"

    def body(self) -> dict[str, Any]:
        """The places by name, as JSON data."""
        ordered = sorted(self.places, key=lambda place: place.name.casefold())
        return {"places": [asdict(place) for place in ordered]}

    def change(self, message: Mapping[str, Any]) -> None:
        """``do``: save (``station``), rename (``to``) or remove ``name``; else `PlaceError`."""
        if self.trouble:
            raise PlaceError(self.trouble)
        name = _name(message.get("name"))
        known = self._find(name)
        match message.get("do"):
            case "save":
                wanted = self._saved(name, message.get("station"))
            case "rename":
                wanted = self._renamed(self._known(name, known), _name(message.get("to")))
            case "remove":
                gone = self._known(name, known)
                wanted = tuple(place for place in self.places if place is not gone)
            case other:
                raise PlaceError(f"do {in_short(other)}: must be save, rename or remove")
        self._write(wanted)
        self.places = wanted

    def _saved(self, name: str, station: object) -> tuple[SavedPlace, ...]:
        if self._find(name) is not None:
            raise PlaceError(f"there is a place named {name!r} already")
        if len(self.places) >= MOST_PLACES:
            raise PlaceError(f"there are {MOST_PLACES} places already: remove one first")
        return (*self.places, self._place(name, station))

    def _renamed(self, place: SavedPlace, to: str) -> tuple[SavedPlace, ...]:
        if self._find(to) not in (None, place):
            raise PlaceError(f"there is a place named {to!r} already")
        return tuple(replace(one, name=to) if one is place else one for one in self.places)

    def _place(self, name: str, station: object) -> SavedPlace:
        try:
            (found,) = read_stations([station])
        except ControlError as error:
            raise PlaceError(str(error)) from None
        if not self._arena.contains((found.x, found.y)):
            raise PlaceError(
                f"({found.x:g}, {found.y:g}) m: outside the arena, {self._arena.ranges}"
            )
        return SavedPlace(name, found.x, found.y, found.heading_rad)

    def _find(self, name: str) -> SavedPlace | None:
        folded = name.casefold()
        return next((one for one in self.places if one.name.casefold() == folded), None)

    @staticmethod
    def _known(name: str, place: SavedPlace | None) -> SavedPlace:
        if place is None:
            raise PlaceError(f"there is no place named {name!r}")
        return place

    def _read(self) -> tuple[SavedPlace, ...]:
        try:
            with self.path.open("rb") as file:
                data = file.read(MOST_BYTES + 1)
        except FileNotFoundError:
            return ()
        if len(data) > MOST_BYTES:
            raise ValueError(f"it has more than {MOST_BYTES} bytes")
        try:
            found = read_object(data)
        except (OutsideError, UnicodeDecodeError):
            raise ValueError("it is not one JSON object") from None
        if found.get("schema") != SCHEMA or not isinstance(found.get("places"), list):
            raise ValueError(f"it is no file of schema {SCHEMA}")
        places = []
        for item in found["places"]:
            if not isinstance(item, dict):
                raise ValueError("a place in it is no object")
            station = {key: item.get(key) for key in ("x_m", "y_m", "heading_rad")}
            (one,) = read_stations([station])
            places.append(SavedPlace(_name(item.get("name")), one.x, one.y, one.heading_rad))
        return tuple(places)

    def _write(self, places: tuple[SavedPlace, ...]) -> None:
        body = {"schema": SCHEMA, "places": [asdict(place) for place in places]}
        text = json.dumps(body, indent=1, allow_nan=False, ensure_ascii=False)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_whole(self.path, text + "\n")
        except (OSError, UnwrittenFileError) as error:
            raise PlaceError(str(error)) from None


def places_file(kept: RecordingSection) -> Path:
    """File beside the journal; without one, among the runs."""
    if kept.journal is None:
        return kept.runs_dir / "places.json"
    return kept.journal.with_name(f"{kept.journal.name}.places.json")


def _name(value: object) -> str:
    limit = f"must be 1 to {NAME_CHARACTERS} printable characters"
    if not isinstance(value, str) or not value.isprintable():
        raise PlaceError(f"name: {limit}")
    name = value.strip()
    if not 1 <= len(name) <= NAME_CHARACTERS:
        raise PlaceError(f"name: {limit}")
    return name
