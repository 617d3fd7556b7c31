"""Environment variables that override a configuration's values.

CLEARWAY_SERIAL__PORT=/dev/ttyUSB0 sets serial.port; two underscores lead one level down, a number
is an entry of a list, and the value is read as YAML. A variable that would set nothing is an error.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from navigation.config.errors import Problem, model_in
from navigation.config.marks import Location, read_document
from navigation.config.sections import Config

ENVIRONMENT_PREFIX = "CLEARWAY_"
OTHERS_VARIABLES = (
    "CLEARWAY_DEBUG", "CLEARWAY_REAL_DATA", "CLEARWAY_FAIL_ON_SKIP", "CLEARWAY_CHROMIUM"
)  # fmt: skip
"""They configure no run."""


def override(
    data: dict[str, Any], environment: Mapping[str, str]
) -> tuple[dict[Location, str], list[Problem]]:
    """Put the environment's values into ``data``; return each one's source, and the problems."""
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
    """Turn CLEARWAY_MISSION__STATIONS__0__X_M into ("mission", "stations", 0, "x_m")."""
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
    """Set a value and create missing sections; False if a list has no such entry."""
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


def sourced(problem: Problem, came_from: Mapping[Location, str]) -> Problem:
    """Blame the environment's variable for the values it set."""
    for where, source in came_from.items():
        if problem.where[: len(where)] == where or where[: len(problem.where)] == problem.where:
            return Problem(problem.where, problem.message, problem.mark, source)
    return problem
