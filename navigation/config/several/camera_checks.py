"""Checks across several cameras over one arena."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from navigation.config.marks import Location
from navigation.config.several.each_camera import camera_of
from navigation.config.values import SIMULATED

_Found = Iterator[tuple[Location, str]]


def names_and_sources_differ(camera: Any, cameras: Any) -> _Found:
    """Two cameras with one name, source or calibration would be one camera twice."""
    if len(cameras) == 1:
        yield ("cameras",), "one camera is written as 'camera': a list needs two or more"
    names: dict[str, int] = {}
    sources: dict[str, int] = {}
    files: dict[str, int] = {}
    for index, entry in enumerate(cameras):
        if entry.name in names:
            first = names[entry.name]
            yield (
                ("cameras", index, "name"),
                f"'{entry.name}' is the name of cameras[{first}] already",
            )
        names.setdefault(entry.name, index)
        own = camera_of(camera, entry)
        for key, value, seen in (
            ("source", own.source, sources),
            ("calibration", own.calibration, files),
        ):
            if value is None or value == SIMULATED:
                continue
            if str(value) in seen:
                where: Location = ("cameras", index)
                if getattr(entry, key) is not None:
                    where = ("cameras", index, key)
                told = f"'{value}' is the {key} of cameras[{seen[str(value)]}] already"
                yield where, f"{told}: each needs its own"
            seen.setdefault(str(value), index)


def each_has_a_calibration(camera: Any, cameras: Any) -> _Found:
    """A scale alone puts every picture's corner in the same place."""
    for index, entry in enumerate(cameras):
        own = camera_of(camera, entry)
        if own.calibration is None and (own.source != SIMULATED or own.metres_per_pixel):
            yield (
                ("cameras", index),
                f"'{entry.name}' needs a calibration of its own (`clearway calibrate` makes one)",
            )
        if own.source == SIMULATED and own.rolling_shutter_ms > 0.0:
            yield (
                ("cameras", index),
                f"rolling_shutter_ms must be 0, not {own.rolling_shutter_ms:g}: the simulated "
                "camera has none",
            )


def markers_of_several_have_places(arena: Any, cameras: Any) -> _Found:
    """A marker's place shows which of several cameras sees it."""
    for index, marker in enumerate(arena.floor_markers if cameras else ()):
        if marker.place_m is None:
            yield (
                ("arena", "floor_markers", index),
                f"floor marker {marker.marker_id} needs a place_m: of several cameras each watches "
                "those that it must see",
            )


def simulated_cameras_are_known(cameras: Any, simulation: Any) -> _Found:
    """Simulated entries name existing cameras, once each."""
    known = {entry.name for entry in cameras}
    first: dict[str, int] = {}
    for index, one in enumerate(() if simulation is None else simulation.cameras):
        where: Location = ("simulation", "cameras", index, "name")
        if one.name not in known:
            there = ", ".join(sorted(known)) or "there are none"
            yield where, f"'{one.name}' is none of cameras: {there}"
        elif one.name in first:
            before = f"simulation.cameras[{first[one.name]}]"
            yield where, f"'{one.name}' is the name of {before} already"
        first.setdefault(one.name, index)
