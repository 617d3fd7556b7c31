"""One line of text, read from left to right, with the place in every error message."""

from __future__ import annotations

import json
import re
from typing import Any

from planner.scene import SceneError, Vec

MAX_COORDINATE = 1e15
"""Sums of squares of coordinates beyond this are no use to the planner."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?(?![\w.])")
_WORD = re.compile(r"[^\s(),#]+")
_SPACE = re.compile(r"\s*")
SEPARATOR = re.compile(r"[\s,]*")


class Scanner:
    """A line and the position in it."""

    def __init__(self, name: str, line_number: int, line: str) -> None:
        self.name = name
        self.line_number = line_number
        self.line = line
        self.at = 0
        self.skip_space()

    def error(self, what: str, at: int | None = None) -> SceneError:
        """Error with file, line and column; ``at`` indexes the line."""
        column = (self.at if at is None else at) + 1
        return SceneError(f"{self.name}:{self.line_number}:{column}: {what}")

    def skip_space(self, pattern: re.Pattern[str] = _SPACE) -> None:
        """Skip the pattern if it is next."""
        match = pattern.match(self.line, self.at)
        self.at = match.end() if match else self.at

    def rest(self) -> str:
        """Unread rest of the line."""
        return self.line[self.at :]

    def at_end(self) -> bool:
        """True if only a comment, or nothing, follows."""
        return self.at >= len(self.line) or self.line[self.at] == "#"

    def end(self) -> None:
        """Refuse anything but a comment."""
        if not self.at_end():
            raise self.error(f"nothing more is expected here, found {self.found()}")

    def found(self) -> str:
        """Text at this position, for an error."""
        rest = self.rest()
        if not rest:
            return "the end of the line"
        word = _WORD.match(rest)
        return repr(word.group()[:24] if word else rest[0])

    def word(self, what: str) -> str:
        """Read a word; ``what`` names it in the error."""
        match = _WORD.match(self.line, self.at)
        if match is None:
            raise self.error(f"expected {what}, found {self.found()}")
        self.at = match.end()
        self.skip_space()
        return match.group()

    def number(self, what: str) -> float:
        """Read a finite number within +-``MAX_COORDINATE``."""
        match = _NUMBER.match(self.line, self.at)
        if match is None:
            raise self.error(f"expected {what}, a finite number, found {self.found()}")
        value = float(match.group())
        if abs(value) > MAX_COORDINATE:
            raise self.error(f"{what} = {value:g}: must lie within +-{MAX_COORDINATE:g}")
        self.at = match.end()
        self.skip_space()
        return value

    def radius(self) -> float:
        """Read a number > 0."""
        at = self.at
        value = self.number("a radius")
        if value <= 0.0:
            raise self.error(f"radius = {value:g}: must be > 0", at)
        return value

    def count(self, what: str, least: int) -> int:
        """Read a whole number >= ``least``."""
        at = self.at
        word = self.word(what)
        if re.fullmatch(r"[0-9]{1,9}", word) is None or int(word) < least:
            raise self.error(f"{what} = {word[:24]}: must be a whole number >= {least}", at)
        return int(word)

    def point(self) -> Vec:
        """Read a point, (x,y)."""
        self.skip_space(SEPARATOR)
        self.symbol("(")
        x = self.number("x")
        self.skip_space(SEPARATOR)
        y = self.number("y")
        self.symbol(")")
        return x, y

    def symbol(self, symbol: str) -> None:
        """Read this very character."""
        if not self.line.startswith(symbol, self.at):
            raise self.error(f"expected {symbol!r}, found {self.found()}")
        self.at += 1
        self.skip_space()

    def points(self, least: int) -> list[Vec]:
        """Read the number of points, at least ``least``, and the points."""
        at = self.at
        count = self.count("the number of vertices", least)
        points: list[Vec] = []
        while self.rest().lstrip(" \t,").startswith("("):
            points.append(self.point())
        if len(points) != count:
            raise self.error(f"{count} vertices announced, {len(points)} found", at)
        return points

    def json(self, what: str) -> Any:
        """Read the rest of the line as strict JSON."""
        try:
            value = json.loads(self.rest(), parse_constant=_refuse_constant)
        except ValueError as error:
            raise self.error(f"{what}: not JSON ({error})") from None
        except RecursionError:
            raise self.error(f"{what}: JSON nested too deeply") from None
        self.at = len(self.line)
        return value


def _refuse_constant(constant: str) -> None:
    raise ValueError(f"{constant} is not a finite number")
