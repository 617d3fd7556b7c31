"""`clearway zone`: the zones of the running daemon."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import click

from navigation.cli.examples import Example, epilog_of
from navigation.cli.options import POSITIVE, SOCKET_OPTION, format_option
from navigation.orders.table import ORDERS

if TYPE_CHECKING:
    from navigation.config.zones import ZoneSection

    NumbersBase = click.ParamType[tuple[tuple[float, ...], ...]]
else:
    NumbersBase = click.ParamType

KINDS: Final = ("keep_out", "slow", "one_way", "lane", "wait")
"""The planner's `ZoneKind`, so that help and completion need not import it."""
MARKS: Final = {"added": "added while running", "changed": "changed while running"}
Places: TypeAlias = tuple[tuple[float, ...], ...]


class PlacesType(NumbersBase):
    """Places such as ``0.5,0.5 1,0.5 1,1``: ``each`` numbers, with a space between places."""

    name = "PLACES"

    def __init__(self, metavar: str, each: int = 2) -> None:
        self.metavar, self.each = metavar, each

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Name in the help."""
        return self.metavar

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> Places:
        """Parse."""
        try:
            places = tuple(
                tuple(float(number) for number in place.split(",")) for place in str(value).split()
            )
        except ValueError:
            places = ()
        if not places or any(len(place) != self.each for place in places):
            self.fail(f"{value!r}: must be {self.metavar}", param, ctx)
        return places


def _texts(order: str) -> dict[str, Any]:
    one = ORDERS[order]
    return {"short_help": one.summary, "epilog": epilog_of(Example(*one.example))}


@click.group(short_help="The zones of the running daemon.")
def command() -> None:
    """Add, remove and list zones: keep out, slow, one way, lane and wait.

    A change holds from the next moment on, in the running daemon only: the configuration stays as
    it is. With recording.journal the next run begins with it.
    """


@command.command(**_texts("zone_put"))
@click.argument("name", required=False)
@click.option("--kind", type=click.Choice(KINDS), help="What holds there.")
@click.option("--polygon", type=PlacesType('"X,Y X,Y X,Y ..."'), help="Corners of the area, in m.")
@click.option("--circle", type=PlacesType("X,Y,RADIUS", 3), help="The area as a circle, in m.")
@click.option(
    "--line", type=PlacesType('"X,Y X,Y ..."'), help="The middle of a band, in its direction."
)
@click.option("--width", type=POSITIVE, help="The band's width, in m.")
@click.option("--robots", metavar="NAME,...", help="Robots that it is for; default: all.")
@click.option("--speed", type=POSITIVE, help="Highest speed inside, in m/s.")
@click.option("--cost", type=POSITIVE, help="Of a lane: cost of a metre, 0.05 to 1.")
@click.option(
    "--file",
    type=click.Path(path_type=Path),
    help="Instead: a YAML file with a list of zones, as in a configuration.",
)
@SOCKET_OPTION
@format_option()
def add(  # noqa: PLR0913 (an argument for each option of the command line)
    name: str | None,
    kind: str | None,
    polygon: Places | None,
    circle: Places | None,
    line: Places | None,
    width: float | None,
    robots: str | None,
    speed: float | None,
    cost: float | None,
    file: Path | None,
    path: Path | None,
    form: str,
) -> None:
    """Add the zone NAME, or replace the one of that name.

    A zone has one area: --polygon, --circle, or --line with --width. The kinds slow, one_way, lane
    and wait may have a --speed, which slow needs.
    """
    from navigation.config.zone_file import ZoneError, read_zone_sections, zone_of
    from navigation.config.zones.in_words import as_written

    given = {
        "name": name,
        "kind": kind,
        "polygon": polygon,
        "circle": None if circle is None else circle[0],
        "line": line,
        "width_m": width,
        "robots": None if robots is None else [one.strip() for one in robots.split(",")],
        "speed_m_s": speed,
        "cost": cost,
    }
    given = {key: value for key, value in given.items() if value is not None}
    if file is not None:
        if given:
            raise click.UsageError("--file has everything: give it alone")
        zones = read_zone_sections(file)
        if not zones:
            raise ZoneError(f"{file}: no zones: must hold one at least")
    else:
        if name is None or kind is None:
            raise click.UsageError("needs NAME and --kind, or --file")
        zones = (zone_of(given),)
    answer: dict[str, Any] = {}
    for number, zone in enumerate(zones):
        request = {"order": "zone_put", "zone": as_written(zone)}
        answer = _send(path, request, after=[one.name for one in zones[:number]])
    _print(answer, form, _words_of(zones))


@command.command(**_texts("zone_remove"))
@click.argument("name")
@SOCKET_OPTION
@format_option()
def remove(name: str, path: Path | None, form: str) -> None:
    """Remove the zone NAME; it stays in the configuration, if it is there."""
    answer = _send(path, {"order": "zone_remove", "name": name})
    _print(answer, form, [f"zone '{name}' removed"])


@command.command(**_texts("zone_undo"))
@SOCKET_OPTION
@format_option()
def undo(path: Path | None, form: str) -> None:
    """Take back the last addition or removal, by this command or on the page."""
    answer = _send(path, {"order": "zone_undo"})
    _print(answer, form, _listed(answer))


@command.command(name="list", **_texts("zone_list"))
@SOCKET_OPTION
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "json", "yaml"]),
    default="text",
    show_default=True,
    help="The form of the answer; yaml can be pasted into a configuration.",
)
def list_them(path: Path | None, form: str) -> None:
    """List the zones in force, and mark what differs from the configuration."""
    answer = _send(path, {"order": "zone_list"})
    if form == "json":
        told = {key: answer[key] for key in ("schema", "zones", "changes", "kept")}
        click.echo(json.dumps(told, allow_nan=False))
        return
    if form == "yaml":
        from navigation.config.zones.in_words import as_yaml

        click.echo(as_yaml(answer["zones"]), nl=False)
        return
    for line in _listed(answer):
        click.echo(line)


def _send(path: Path | None, request: dict[str, Any], after: Sequence[str] = ()) -> dict[str, Any]:
    """Answer of the daemon; an error also says which zones were added before."""
    from navigation.control import ControlError, NoDaemonError, send_order

    try:
        return send_order(path, request)
    except NoDaemonError:
        raise
    except ControlError as error:
        if not after:
            raise
        raise ControlError(f"{error}; added before: {', '.join(after)}") from None


def _print(answer: dict[str, Any], form: str, lines: Iterable[str]) -> None:
    if form == "json":
        click.echo(json.dumps(answer, allow_nan=False))
        return
    from navigation.cli.running.orders import print_state

    for line in lines:
        click.echo(line)
    if not answer["kept"]:
        click.echo(
            "this ends with the program: no recording.journal, or its file of zones is damaged"
        )
    print_state(answer)


def _words_of(zones: Iterable[ZoneSection]) -> list[str]:
    from navigation.config.zones.in_words import in_words

    return [in_words(one) for one in zones]


def _sections(answer: dict[str, Any]) -> list[ZoneSection]:
    from navigation.config.zone_file import zone_of
    from planner.zones.areas import MaskArea

    cells = MaskArea(())  # the daemon knows them: its files may be gone, or not for this user
    return [zone_of(one, cells) for one in answer["zones"]]


def _listed(answer: dict[str, Any]) -> list[str]:
    changes = answer["changes"]
    sections = _sections(answer)
    lines = [
        words + (f" ({MARKS[changes[one.name]]})" if one.name in changes else "")
        for one, words in zip(sections, _words_of(sections), strict=True)
    ]
    removed = [name for name, what in changes.items() if what == "removed"]
    lines += [f"zone '{name}' of the configuration: removed while running" for name in removed]
    return lines or ["no zones"]
