"""Common arguments and options of commands, checked where they are typed."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import click

from vision.binarise import METHODS, Method, Polarity

Decorator: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]


STANDARD_STREAM = Path("-")
"""Standard input or output."""


class Binarising(NamedTuple):
    """Arguments of ``vision.extract`` for making a picture black and white."""

    polarity: Polarity = "dark"
    method: Method = "auto"
    threshold: float | None = None


@dataclass(frozen=True, slots=True)
class StationArgument:
    """A place, and a heading or None for any; radians in the scene's own sense."""

    x: float
    y: float
    heading_rad: float | None = None

    def as_tuple(self) -> tuple[float, ...]:
        """The form that ``Roadmap.plan`` takes."""
        return (self.x, self.y) if self.heading_rad is None else (self.x, self.y, self.heading_rad)


if TYPE_CHECKING:  # for the type checker only: click 8.1 cannot be subscripted
    StationBase = click.ParamType[StationArgument]
    NumberBase = click.ParamType[float]
    PreferenceBase = click.ParamType[str | float]
    OutputBase = click.ParamType[Path]
else:
    StationBase = NumberBase = PreferenceBase = OutputBase = click.ParamType


class StationType(StationBase):
    """``X,Y`` or ``X,Y,DEG``, finite, in the scene's units and its own sense of turning."""

    name = "X,Y[,DEG]"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Name in the help."""
        return self.name

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> StationArgument:
        """Parse."""
        if isinstance(value, StationArgument):
            return value
        numbers = [_finite(word) for word in str(value).split(",")]
        if len(numbers) not in (2, 3) or None in numbers:
            self.fail(f"{value!r}: must be X,Y or X,Y,DEG, finite numbers", param, ctx)
        x, y, *degrees = (float(n) for n in numbers if n is not None)
        return StationArgument(x, y, math.radians(degrees[0]) if degrees else None)


class NumberType(NumberBase):
    """A finite number that is > 0, or >= 0 with ``zero``."""

    name = "NUMBER"

    def __init__(self, *, zero: bool = False) -> None:
        self.zero = zero

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Parse."""
        number = _finite(str(value))
        if number is None or number < 0.0 or (number == 0.0 and not self.zero):
            limit = ">= 0" if self.zero else "> 0"
            self.fail(f"{value!r}: must be a finite number {limit}", param, ctx)
        return number


class PreferenceType(PreferenceBase):
    """``clearance``, ``length``, ``balanced``, or a number from 0 (length) to 1 (clearance)."""

    name = "clearance|length|balanced|0..1"
    names = ("clearance", "length", "balanced")

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Name in the help."""
        return f"[{self.name}]"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | float:
        """Parse."""
        if value in self.names:
            return str(value)
        number = _finite(str(value))
        if number is None or not 0.0 <= number <= 1.0:
            self.fail(
                f"{value!r}: must be clearance, length, balanced or a number from 0 (length)"
                " to 1 (clearance)",
                param,
                ctx,
            )
        return number


class OutputType(OutputBase):
    """A file to be written, in an existing folder; with ``suffixes``, one of those kinds.

    Checked where it is typed: no one waits for an answer that cannot be kept. With ``stream``,
    ``-`` is standard output.
    """

    name = "FILE"

    def __init__(self, *suffixes: str, stream: bool = False) -> None:
        self.suffixes, self.stream = suffixes, stream

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Check the name."""
        path = Path(value)
        if self.stream and path == STANDARD_STREAM:
            return path
        if self.suffixes and path.suffix.lower() not in self.suffixes:
            *others, last = self.suffixes
            kinds = f"{', '.join(others)} or {last}" if others else last
            self.fail(f"{path}: must end in {kinds}", param, ctx)
        if path.is_dir():
            self.fail(f"{path}: is a directory, must be a file", param, ctx)
        if not path.parent.is_dir():
            self.fail(f"{path}: there is no directory {path.parent}", param, ctx)
        return path


class RecordingType(OutputType):
    """FILE.mcap, which is never overwritten, or a folder, which is made if it is missing."""

    def __init__(self) -> None:
        super().__init__(".mcap")

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        """Check the name."""
        path = Path(value)
        if path.suffix.lower() in self.suffixes:
            path = super().convert(value, param, ctx)
            if path.exists():
                self.fail(f"{path}: exists already, and a recording overwrites nothing", param, ctx)
        elif path.exists() and not path.is_dir():
            self.fail(f"{path}: is a file, must be a new FILE.mcap or a directory", param, ctx)
        elif path.suffix and not path.exists():
            self.fail(f"{path}: must end in .mcap, or be a directory", param, ctx)
        return path


class InputType(click.Path):
    """A file that is read, ``-`` standard input; an empty name would be the present folder."""

    def __init__(self) -> None:
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check the name."""
        if not str(value):
            self.fail("the name is empty: must be a file", param, ctx)
        return super().convert(value, param, ctx)


INPUT = InputType()
OUTPUT = OutputType(stream=True)
DRAWING = OutputType(".svg", ".png")
STATION = StationType()
POSITIVE = NumberType()
NOT_NEGATIVE = NumberType(zero=True)
PREFERENCE = PreferenceType()


def _finite(word: str) -> float | None:
    """The word as a finite number, else None; no underscores."""
    try:
        number = float(word)
    except ValueError:
        return None
    return number if math.isfinite(number) and "_" not in word else None


def format_option(meaning: str = "The form of the answer.") -> Decorator:
    """``--format text|json``, as ``form``."""
    choice = click.Choice(["text", "json"])
    return click.option(
        "--format", "form", type=choice, default="text", show_default=True, help=meaning
    )


def binarise_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """``--polarity``, ``--method`` and ``--threshold``, as ``binarising``."""

    @click.option(
        "--polarity",
        type=click.Choice(["dark", "light", "auto"]),
        default="dark",
        show_default=True,
        help="For a picture: whether the obstacles are dark or light.",
    )
    @click.option(
        "--method",
        type=click.Choice(METHODS),
        default="auto",
        show_default=True,
        help="How a picture is made black and white.",
    )
    @click.option("--threshold", type=float, help="The grey level of method fixed, 0 to 255.")
    @wraps(command)
    def with_one(polarity: Polarity, method: Method, threshold: float | None, **others: Any) -> Any:
        if threshold is not None and not 0.0 <= threshold <= 255.0:
            raise click.BadParameter(f"{threshold}: must lie in 0..255", param_hint="--threshold")
        if threshold is not None and method != "fixed":
            raise click.BadParameter("is for --method fixed only", param_hint="--threshold")
        return command(binarising=Binarising(polarity, method, threshold), **others)

    return with_one


RADIUS_OPTION = click.option(
    "--radius", type=POSITIVE, required=True, help="The robot's radius, in the scene's units."
)
SPACING_OPTION = click.option(
    "--spacing", type=POSITIVE, help="Largest distance between generators; less than 2 radius."
)


def check_spacing(spacing: float | None, radius: float) -> None:
    """Raise click's error about a ``--spacing`` that is too wide for the radius."""
    if spacing is not None and spacing >= 2.0 * radius:
        raise click.BadParameter(
            f"{spacing:g}: must be < 2 radius = {2.0 * radius:g}", param_hint="--spacing"
        )


ZONES_OPTION = click.option(
    "--zones",
    "zones_file",
    type=INPUT,
    help="Zones to keep to: a YAML list as in a configuration, in the scene's units.",
)
SOCKET_OPTION = click.option(
    "--socket", "path", type=click.Path(path_type=Path), help="The daemon's socket."
)
LEAST_AREA_OPTION = click.option(
    "--least-area",
    type=POSITIVE,
    metavar="AREA",
    help="Leave out obstacles smaller than this, in square units of the scene; paths may cross "
    "them.",
)
