"""The configuration of a run: read, overridden from the environment, checked, then trusted.

Rules
- `load_config` gives a whole `Config` or raises `ConfigError` with every problem at once.
- Environment variables override the file: CLEARWAY_SERIAL__PORT=/dev/ttyUSB0 sets
  serial.port; two underscores go one level down, a number is an entry of a list, and the value
  is read as YAML.
- What spans sections (`config_checks`) is told together with the errors of other sections.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from navigation.config_checks import CHECKS
from navigation.config_errors import ConfigError, Problem, mark_of, model_in, problems_of
from navigation.config_marks import Document, Location, read_document
from navigation.config_sections import Config
from planner.path import Limits

__all__ = ["Config", "ConfigError", "limits_of", "load_config", "parse_config"]

ENVIRONMENT_PREFIX = "CLEARWAY_"
OTHERS_VARIABLES = (
    "CLEARWAY_DEBUG", "CLEARWAY_REAL_DATA", "CLEARWAY_FAIL_ON_SKIP", "CLEARWAY_CHROMIUM"
)  # fmt: skip
"""The command line's and the tests'; they configure no run."""


def load_config(path: str | Path, environment: Mapping[str, str] | None = None) -> Config:
    """The configuration in a file, with ``environment``'s overrides (default: the process's).

    Raises ``ConfigError`` (exit code 78) with every problem: unreadable file, YAML, unknown
    or missing keys, wrong types and values, and what does not fit together.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8")
    except OSError as error:
        raise ConfigError(str(path), [Problem((), error.strerror or str(error))]) from error
    except UnicodeDecodeError as error:
        sentence = f"is not UTF-8 text (byte {error.start} is 0x{error.object[error.start]:02x})"
        raise ConfigError(str(path), [Problem((), sentence)]) from error
    overrides = os.environ if environment is None else environment
    return parse_config(text, str(path), file.parent, overrides)


def parse_config(
    text: str,
    name: str = "configuration",
    folder: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> Config:
    """The configuration in a text; ``name`` is used in errors, ``folder`` for relative files."""
    document = read_document(text)
    defects = [Problem((), defect.message, defect.mark) for defect in document.defects]
    if document.data is None and not defects:
        raise ConfigError(name, [Problem((), "is empty; `clearway init` writes one to start with")])
    if defects and not isinstance(document.data, dict):
        raise ConfigError(name, defects, text)
    if not isinstance(document.data, dict):
        place = mark_of(document, ())
        raise ConfigError(name, [Problem((), "must be sections (key: value lines)", place)], text)
    from_environment, bad_overrides = _override(document.data, environment or {})
    config, problems, sound = _validate(document, folder)
    told = [_sourced(problem, from_environment) for problem in problems]
    if config is None or defects or told or bad_overrides:
        raise ConfigError(name, in_order([*defects, *told, *bad_overrides]), text, sound)
    return config


def limits_of(config: Config) -> Limits:
    """What the robot can do, as the planner takes it; metres."""
    robot, planning = config.robot, config.planning
    return Limits(
        speed=robot.speed_m_s,
        acceleration=robot.acceleration_m_s2,
        lateral_acceleration=robot.lateral_acceleration_m_s2,
        angular_rate_rad_s=robot.angular_rate_rad_s,
        angular_acceleration_rad_s2=robot.angular_acceleration_rad_s2,
        jerk=robot.jerk_m_s3,
        spacing=planning.waypoint_spacing_m,
        chord_tolerance=planning.chord_tolerance_m,
        slow_clearance=planning.slow_clearance_m,
        slow_speed=planning.slow_speed_m_s,
        turns_on_spot=robot.turns_on_spot,
    )


def _validate(
    document: Document, folder: Path | None
) -> tuple[Config | None, list[Problem], dict[str, Any]]:
    """The configuration, what is wrong, and the sections that can be trusted all the same."""
    context = {"folder": folder}
    try:
        config = Config.model_validate(document.data, context=context)
    except ValidationError as error:
        errors = error.errors(include_url=False)
        problems = list(problems_of(errors, document, Config))
        unknown = [tuple(e["loc"]) for e in errors if e["type"] == "extra_forbidden"]
        bad = {str(e["loc"][0]) for e in errors if tuple(e["loc"]) not in unknown}
        sound = _sound_sections(_without(document.data, unknown), bad, context)
        return None, [*problems, *_cross_problems(sound, document)], sound
    sections = {name: getattr(config, name) for name in Config.model_fields}
    return config, list(_cross_problems(sections, document)), sections


def _without(data: Any, keys: Sequence[Location]) -> Any:
    """The data without those keys; they are told, and the rest can be looked at."""
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
    """The sections without errors of their own, for the checks that need no others."""
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


def _override(
    data: dict[str, Any], environment: Mapping[str, str]
) -> tuple[dict[Location, str], list[Problem]]:
    """Put the environment's values into ``data``; where each came from, and what is wrong."""
    came_from: dict[Location, str] = {}
    problems: list[Problem] = []
    for name in sorted(environment):
        if not name.startswith(ENVIRONMENT_PREFIX):
            continue
        source = f"environment {name}"
        if "__" not in name:
            problems += _sets_nothing(name, source)
            continue
        where = _location(name)
        value = read_document(environment[name])
        if value.defects:
            problems.append(Problem(where, value.defects[0].message, source=source))
        elif _set(data, where, value.data):
            came_from[where] = source
        else:
            problems.append(Problem(where, "there is no such entry in the list", source=source))
    return came_from, problems


def _location(name: str) -> Location:
    """CLEARWAY_MISSION__STATIONS__0__X_M as ("mission", "stations", 0, "x_m")."""
    parts = name[len(ENVIRONMENT_PREFIX) :].lower().split("__")
    return tuple(int(part) if part.isdecimal() else part for part in parts)


def _sets_nothing(name: str, source: str) -> Iterator[Problem]:
    """CLEARWAY_SERIAL_PORT would be ignored for ever where CLEARWAY_SERIAL__PORT was meant."""
    rest = name[len(ENVIRONMENT_PREFIX) :].lower()
    if name in OTHERS_VARIABLES:
        return
    if rest in Config.model_fields:
        key = f"{name}__{_first_key(rest).upper()}"
        yield Problem((), f"sets nothing: name a key of the section, as in {key}", source=source)
        return
    for section in Config.model_fields:
        if rest.startswith(f"{section}_"):
            meant = f"{ENVIRONMENT_PREFIX}{section.upper()}__{rest[len(section) + 1 :].upper()}"
            yield Problem((), f"sets nothing; did you mean {meant}?", source=source)
            return
    sections = ", ".join(Config.model_fields)
    yield Problem((), f"sets nothing: the sections are {sections}", source=source)


def _first_key(section: str) -> str:
    model = model_in(Config.model_fields[section].annotation)
    return next(iter(model.model_fields)) if model else "0"


def _set(data: dict[str, Any], where: Location, value: Any) -> bool:
    """Set a value, making the sections on the way; False where a list has no such entry."""
    here: Any = data
    for part, following in zip(where, (*where[1:], None), strict=True):
        if isinstance(here, list) and not (isinstance(part, int) and part < len(here)):
            return False
        key: Any = part if isinstance(here, list) else str(part)
        if following is None:
            here[key] = value
            return True
        inner = here[key] if isinstance(here, list) else here.get(key)
        if not isinstance(inner, list if isinstance(following, int) else dict):
            inner = here[key] = {}
        here = inner
    return True


def _sourced(problem: Problem, came_from: Mapping[Location, str]) -> Problem:
    """Blame the environment's variable for what it set."""
    for where, source in came_from.items():
        if problem.where[: len(where)] == where or where[: len(problem.where)] == problem.where:
            return Problem(problem.where, problem.message, problem.mark, source)
    return problem


def in_order(problems: list[Problem]) -> list[Problem]:
    """As they stand in the file, from the top."""
    return sorted(problems, key=lambda p: (p.mark.line, p.mark.column) if p.mark else (0, 0))


def _cross_problems(sections: Mapping[str, Any], document: Document) -> Iterator[Problem]:
    for needed, check in CHECKS:
        if all(name in sections for name in needed):
            for where, sentence in check(*(sections[name] for name in needed)):
                yield Problem(where, sentence, mark_of(document, where))
