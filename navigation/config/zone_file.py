"""Zones from outside a configuration: one of an order, or a file's list.

A file is YAML: the list itself, or the key `zones` with it. Relative masks are meant from the
file's folder. Coordinates and speeds are in the units of the scene that the zones are for.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import Field, ValidationError

from navigation.config.errors import ConfigError, Problem, key_name, mark_of, problems_of
from navigation.config.load import read_source
from navigation.config.marks import Document, read_document
from navigation.config.values import Section
from navigation.config.zones.section import MASK, MOST_ZONES, ZoneSection
from navigation.config.zones.zone_checks import zone_names_differ
from navigation.shared.outside import in_short, printable
from planner.formats.mask_files import mask_picture
from planner.scene import SceneError
from planner.zones.areas import MaskArea
from planner.zones.zone import Zone

MOST_SENTENCE = 300
"""Characters of an error about a zone from outside: chosen."""


class ZoneError(ValueError):
    """Error: a zone, or a file of zones, is invalid."""


class _ZoneList(Section):
    zones: tuple[ZoneSection, ...] = Field(max_length=MOST_ZONES, description="the zones")


def zone_of(value: Any, mask_area: MaskArea | None = None) -> ZoneSection:
    """Zone of a mapping as in a configuration; `ZoneError` in one sentence.

    A mask's path must be absolute: there is no folder that it could be relative to. Its file is not
    read where ``mask_area`` is given.
    """
    if not isinstance(value, Mapping):
        raise ZoneError(f"zone: must be an object of name, kind and an area, not {in_short(value)}")
    mask = value.get("mask")
    if isinstance(mask, str) and not Path(mask).is_absolute():
        raise ZoneError(f"zone.mask = {in_short(mask)}: must be an absolute path")
    try:
        return ZoneSection.model_validate(value, context={MASK: mask_area})
    except ValidationError as error:
        found = next(iter(problems_of(error.errors(include_url=False), Document(""), ZoneSection)))
        where = key_name(("zone", *found.where))
        raise ZoneError(printable(f"{where}: {found.message}", MOST_SENTENCE)) from None


def ordered_zone(value: Any, masks_in: Path | None) -> ZoneSection:
    """Return the zone of an order, as :func:`zone_of`, which names no file outside ``masks_in``.

    A mask and its picture are in that folder or below it, links followed; neither is opened before
    that is known. None allows no mask.
    """
    mask = value.get("mask") if isinstance(value, Mapping) else None
    if isinstance(mask, str) and Path(mask).is_absolute():
        _check_place(mask, Path(mask), masks_in)
        with contextlib.suppress(SceneError):  # which `zone_of` finds too, and reports
            _check_place(mask, mask_picture(mask), masks_in)
    return zone_of(value)


def _check_place(mask: str, file: Path, folder: Path | None) -> None:
    if folder is None:
        raise ZoneError("zone.mask: this run has no configuration file that a mask could be beside")
    try:
        is_there = file.resolve().is_relative_to(folder.resolve())
    except (OSError, RuntimeError, ValueError):  # no name of a file, or links in a circle
        is_there = False
    if not is_there:
        what = "" if file == Path(mask) else "its picture "
        sentence = f"{what}must be in the configuration's folder, {folder}"
        raise ZoneError(printable(f"zone.mask = {in_short(mask)}: {sentence}", MOST_SENTENCE))


def read_zone_sections(path: Path) -> tuple[ZoneSection, ...]:
    """A file's zones as they are written; `ZoneError` with every problem."""
    try:
        text = read_source(path)
        return _zones_in(text, path)
    except ConfigError as error:
        raise ZoneError(str(error)) from None


def read_zones(path: Path) -> tuple[Zone, ...]:
    """A file's zones as the planner has them; `ZoneError` with every problem."""
    return tuple(one.zone() for one in read_zone_sections(path))


def _zones_in(text: str, path: Path) -> tuple[ZoneSection, ...]:
    document = _under_its_key(read_document(text))
    defects = [Problem((), defect.message, defect.mark) for defect in document.defects]
    if defects:
        raise ConfigError(str(path), defects, text)
    if not isinstance(document.data, dict):
        sentence = "must be a list of zones, or the key 'zones' with one"
        raise ConfigError(str(path), [Problem((), sentence)], text)
    try:
        zones = _ZoneList.model_validate(document.data, context={"folder": path.parent}).zones
    except ValidationError as error:
        errors = error.errors(include_url=False)
        raise ConfigError(str(path), list(problems_of(errors, document, _ZoneList)), text) from None
    problems = [
        Problem(where, sentence, mark_of(document, where))
        for where, sentence in zone_names_differ(zones)
    ]
    if problems:
        raise ConfigError(str(path), problems, text)
    return zones


def _under_its_key(document: Document) -> Document:
    if not isinstance(document.data, list):
        return document
    return Document(
        document.text,
        {"zones": document.data},
        {("zones", *where): mark for where, mark in document.keys.items()},
        {("zones", *where): mark for where, mark in document.values.items()},
        document.defects,
    )
