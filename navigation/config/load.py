"""Reads and checks a configuration and the environment's overrides; the result is trusted.

Problems across sections (`checks`) are reported together with the sections' own.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from pydantic import TypeAdapter, ValidationError

from navigation.config.checks import CHECKS
from navigation.config.errors import ConfigError, Problem, in_order, mark_of, problems_of
from navigation.config.marks import Document, Location, read_document
from navigation.config.overrides import override, sourced
from navigation.config.secrecy.secret_places import secrets_in_environment, secrets_in_source
from navigation.config.secrecy.secrets import learn
from navigation.config.sections import Config
from navigation.config.several.defaults import (
    found_in,
    is_overridden,
    with_source_of_cameras,
)
from navigation.config.unknown_keys import values_of_unknown_keys

MOST_BYTES: Final = 2_000_000
"""The longest text takes no more in UTF-8."""


def load_config(path: str | Path, environment: Mapping[str, str] | None = None) -> Config:
    """Load a file's configuration, with ``environment``'s overrides (default: the process's).

    ``ConfigError`` (exit code 78) with every problem.
    """
    file = Path(path)
    text = read_source(file)
    overrides = os.environ if environment is None else environment
    return parse_config(text, str(path), file.parent, overrides)


def read_source(file: Path) -> str:
    """Read a configuration's text; ``ConfigError`` if it is unreadable, too long or no UTF-8."""
    try:
        with file.open("rb") as source:
            data = source.read(MOST_BYTES + 1)
    except OSError as error:
        raise ConfigError(str(file), [Problem((), error.strerror or str(error))]) from error
    if len(data) > MOST_BYTES:
        sentence = f"is larger than {MOST_BYTES} bytes: no configuration"
        raise ConfigError(str(file), [Problem((), sentence)])
    try:
        return data.decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        sentence = f"is not UTF-8 text (byte {error.start} is 0x{error.object[error.start]:02x})"
        raise ConfigError(str(file), [Problem((), sentence)]) from error


def parse_config(
    text: str,
    name: str = "configuration",
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> Config:
    """Parse a configuration's text; ``name`` is used in errors, ``folder`` for relative files."""
    learn(secrets_in_source(text))
    learn(secrets_in_environment(environment or {}))
    document = read_document(text)
    defects = [Problem((), defect.message, defect.mark) for defect in document.defects]
    if document.data is None and not defects:
        raise ConfigError(name, [Problem((), "is empty; `clearway init` writes one to start with")])
    if defects and not isinstance(document.data, dict):
        raise ConfigError(name, defects, text, unknown=values_of_unknown_keys(text, Config))
    if not isinstance(document.data, dict):
        place = mark_of(document, ())
        raise ConfigError(name, [Problem((), "must be sections (key: value lines)", place)], text)
    from_environment, bad_overrides = override(document.data, environment or {})
    config, problems, sound = _validate(document, folder)
    told = [sourced(problem, from_environment) for problem in problems]
    if config is None or defects or told or bad_overrides:
        unknown = values_of_unknown_keys(text, Config)
        problems = in_order([*defects, *told, *bad_overrides])
        raise ConfigError(name, problems, text, sound, unknown)
    return config


def _validate(
    document: Document, folder: Path | None
) -> tuple[Config | None, list[Problem], dict[str, Any]]:
    context = {"folder": folder}
    data = with_source_of_cameras(document.data)
    try:
        config = Config.model_validate(data, context=context)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        problems = list(problems_of(errors, document, Config))
        unknown = [tuple(e["loc"]) for e in errors if e["type"] == "extra_forbidden"]
        bad = {str(e["loc"][0]) for e in errors if tuple(e["loc"]) not in unknown}
        sound = _sound_sections(_without(data, unknown), bad, context)
        return None, [*problems, *_cross_problems(sound, document)], sound
    sections = {name: getattr(config, name) for name in Config.model_fields}
    return config, list(_cross_problems(sections, document)), sections


def _without(data: Any, keys: Sequence[Location]) -> Any:
    """The data without those keys: they are reported, and the rest can be checked."""
    here = {where[0] for where in keys if len(where) == 1}
    if isinstance(data, dict):
        pairs = data.items()
        return {k: _without(v, _below(keys, k)) for k, v in pairs if k not in here}
    if isinstance(data, list):
        return [_without(v, _below(keys, i)) for i, v in enumerate(data)]
    return data


def _below(keys: Sequence[Location], part: Any) -> list[Location]:
    return [where[1:] for where in keys if len(where) > 1 and where[0] == part]


def _sound_sections(
    data: dict[str, Any], bad: set[str], context: dict[str, Path | None]
) -> dict[str, Any]:
    sound: dict[str, Any] = {}
    for name, field in Config.model_fields.items():
        if name in bad:
            continue
        if name in data:
            adapter: TypeAdapter[Any] = TypeAdapter(field.rebuild_annotation())
            sound[name] = adapter.validate_python(data[name], context=context)
        elif not field.is_required():
            sound[name] = field.default
    return sound


def _cross_problems(sections: Mapping[str, Any], document: Document) -> Iterator[Problem]:
    for needed, check in CHECKS:
        if all(name in sections for name in needed):
            for where, sentence in found_in(sections, needed, check):
                if is_overridden(sections, where):
                    continue  # no entry uses the value; each entry's own is checked
                yield Problem(where, sentence, mark_of(document, where))
