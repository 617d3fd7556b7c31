"""`clearway plan`: one path."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from navigation.cli.options import (
    DRAWING,
    INPUT,
    LEAST_AREA_OPTION,
    NOT_NEGATIVE,
    OUTPUT,
    PREFERENCE,
    RADIUS_OPTION,
    SPACING_OPTION,
    STANDARD_STREAM,
    STATION,
    ZONES_OPTION,
    Binarising,
    StationArgument,
    binarise_options,
    check_spacing,
    format_option,
)
from navigation.cli.outputs import (
    CommandError,
    Stopwatch,
    keep_apart,
    tell_times,
    warn_of_doubts,
    write_text,
)
from navigation.cli.progress import long_work

if TYPE_CHECKING:
    from navigation.cli.pictures.plan_answer import PlanOutput
    from planner.path import NoPath
    from planner.path import Path as PlannedPath
    from planner.roadmap.roadmap import Roadmap
    from planner.scene import Scene
    from planner.zones.zone import Zone
    from planner.zones.zoned_roadmap import ZonedRoadmap

NO_PATH = 3


@click.command(short_help="One plan through a picture, scene or map.")
@click.argument("source", type=INPUT)
@click.option("--start", type=STATION, required=True, help="Where the robot is.")
@click.option("--goal", type=STATION, required=True, help="Where it has to go.")
@RADIUS_OPTION
@click.option(
    "--via", type=STATION, multiple=True, help="A station to pass on the way; repeatable."
)
@click.option(
    "--order",
    type=click.Choice(["fixed", "best"]),
    default="fixed",
    show_default=True,
    help="The stations' order: as given, or the one that makes the whole path shortest.",
)
@click.option(
    "--margin", type=NOT_NEGATIVE, default=0.0, help="Clearance to keep on top of the radius."
)
@SPACING_OPTION
@click.option(
    "--prefer",
    type=PREFERENCE,
    default="balanced",
    show_default=True,
    help="What to prefer in a path: clearance, length, or between.",
)
@click.option(
    "--alternatives",
    type=click.IntRange(0, 20),
    default=0,
    metavar="K",
    help="Other routes round the obstacles, besides the best.",
)
@ZONES_OPTION
@binarise_options
@LEAST_AREA_OPTION
@format_option()
@click.option("--render", type=DRAWING, help="Draw the plan: FILE.svg or FILE.png.")
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
def command(  # noqa: PLR0913 (an argument for each option of the command line)
    source: Path,
    start: StationArgument,
    goal: StationArgument,
    radius: float,
    via: tuple[StationArgument, ...],
    order: Literal["fixed", "best"],
    margin: float,
    spacing: float | None,
    prefer: str | float,
    alternatives: int,
    zones_file: Path | None,
    binarising: Binarising,
    least_area: float | None,
    form: str,
    render: Path | None,
    output: Path | None,
) -> int:
    """Plan a path through SOURCE: a picture, a scene, a ROS map's YAML or a MovingAI .map.

    A scene is what clearway extract writes, as text or JSON. Coordinates are the source's own:
    pixels with y down for a picture, metres with y up for a ROS map, cells for a .map. Exits 3 if
    there is no path, and says why.
    """
    from navigation.cli.pictures.sources import compile_for, hold_points, load_source, zones_in
    from planner.motion.smooth import round_corners
    from planner.motion.trajectory import default_limits
    from planner.path import Path as PlannedPath
    from planner.zones.zoned_roadmap import with_zones

    check_spacing(spacing, radius)
    keep_apart((("--output", output), ("--render", render)), (source, zones_file))
    zones = zones_in(zones_file)
    compile_for(source)
    times_ms = Stopwatch()
    with long_work("looking for obstacles"):
        scene = load_source(source, binarising, least_area)
    warn_of_doubts(scene, source)
    stations = [start, *via, goal]
    room = 4.0 * (radius + margin)
    scene = hold_points(scene, [(s.x, s.y) for s in stations], room)
    with long_work("building the roadmap") as begin:
        roadmap = timed_roadmap(scene, radius, spacing, times_ms)
        begin("planning")
        try:
            zoned = with_zones(roadmap, zones, speed=default_limits(radius).speed)
            planned = zoned.plan(
                start.as_tuple(),
                goal.as_tuple(),
                prefer=prefer,
                via=[s.as_tuple() for s in via],
                order=order,
                alternatives=alternatives,
                margin=margin,
            )
        except ValueError as error:
            raise CommandError(str(error)) from error
        begin("smoothing")
        path = planned
        if isinstance(planned, PlannedPath):
            path = round_corners(planned, zoned, prefer=prefer, margin=margin)
        times_ms.end("path")
    answer = _answer(scene, zoned, planned, path, times_ms)
    try:
        if render is not None:
            with long_work("drawing"):
                _render(render, answer, zoned.closed, stations, zones)
            times_ms.end("render")
    finally:  # give the answer, whatever becomes of its picture
        times_ms.end_all()
        _tell(answer, form, output)
    if answer.trajectory is None:
        click.echo(f"clearway: {answer.no_path_sentence()}", err=True)
    if form == "text":
        tell_times(answer.stage_times_ms())
    return NO_PATH if answer.trajectory is None else 0


def timed_roadmap(
    scene: Scene,
    radius: float,
    spacing: float | None,
    times_ms: Stopwatch,
    least_branch: float = 0.0,
) -> Roadmap:
    """Build the roadmap; add its stages to those of the scene."""
    from planner.roadmap.roadmap import build_roadmap

    times_ms.update(scene.timings_ms)
    times_ms.begin()
    try:
        return build_roadmap(
            scene, radius, spacing=spacing, least_branch=least_branch, lap=times_ms.end
        )
    except ValueError as error:
        raise CommandError(str(error)) from error


def _answer(
    scene: Scene,
    zoned: ZonedRoadmap,
    planned: PlannedPath | NoPath,
    path: PlannedPath | NoPath,
    times_ms: Stopwatch,
) -> PlanOutput:
    from navigation.cli.pictures.plan_answer import PlanOutput
    from planner.motion.trajectory import default_limits, time_path
    from planner.path import NoPath

    trajectory, roadmap = None, zoned.walls
    limits = default_limits(roadmap.radius)
    if not isinstance(path, NoPath):
        trajectory = time_path(
            path, limits, clearance=roadmap.clearance, speed_limits=zoned.speed_limits
        )
        times_ms.end("trajectory")
    return PlanOutput(
        scene,
        roadmap.radius,
        path,
        planned,
        trajectory,
        limits,
        counts={
            "border_pixels": scene.border_pixels,
            "vertices": scene.vertex_count,
            **roadmap.counts,
        },
        timings_ms=times_ms,
        remarks=(*scene.remarks, *roadmap.remarks, *path.remarks),
    )


def _tell(answer: PlanOutput, form: str, output: Path | None) -> None:
    """Write the answer; only a file gets the reason for a missing path."""
    if form == "json":
        text = answer.as_json() + "\n"
    else:
        to_file = output is not None and output != STANDARD_STREAM
        text = answer.as_text(with_reason=to_file)
    write_text(output, text)


def _render(
    file: Path,
    answer: PlanOutput,
    roadmap: Roadmap,
    stations: list[StationArgument],
    zones: tuple[Zone, ...],
) -> None:
    from navigation.draw import save_picture

    places = [s.as_tuple() for s in stations]
    save_picture(
        file,
        answer.scene,
        roadmap=roadmap,
        path=answer.path,
        trajectory=answer.trajectory,
        stations=places,
        zones=zones,
    )
