"""`clearway audit`: checks a route graph against a map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import (
    DRAWING,
    INPUT,
    OUTPUT,
    POSITIVE,
    RADIUS_OPTION,
    STATION,
    OutputType,
    StationArgument,
)
from navigation.cli.outputs import (
    CommandError,
    Stopwatch,
    keep_apart,
    named,
    tell_times,
    write_text,
)
from navigation.cli.progress import long_work

if TYPE_CHECKING:
    from planner.formats.mask_files import SpeedLevel
    from planner.graph_audit.audit import GraphAudit
    from planner.scene import Scene

UNSAFE = 3
"""Exit code, the same as for no path."""


@click.command(short_help="What is wrong with a route graph.")
@click.argument("graph_file", metavar="GRAPH", type=INPUT)
@click.option(
    "--map",
    "map_file",
    type=INPUT,
    required=True,
    help="The map: a ROS map's YAML, a scene text, a MovingAI .map or a picture.",
)
@RADIUS_OPTION
@click.option("--keepout", type=INPUT, help="A keep-out mask of Nav2: its YAML.")
@click.option("--speed", type=INPUT, help="A speed mask of Nav2: its YAML.")
@click.option(
    "--speed-filter",
    type=(click.Choice(["percent", "m/s"]), float, float),
    default=("percent", 100.0, -1.0),
    show_default=True,
    metavar="UNIT BASE MULTIPLIER",
    help="What the speed mask's numbers mean: those of Nav2's filter info server.",
)
@click.option(
    "--max-speed",
    type=POSITIVE,
    help="The robot's largest speed in m/s, to compare limits in percent with those in m/s.",
)
@click.option("--passing", is_flag=True, help="Report where two robots cannot pass each other.")
@click.option(
    "--turning-radius", type=POSITIVE, help="Report turns tighter than the robot can drive."
)
@click.option(
    "--goal",
    "goals",
    type=STATION,
    multiple=True,
    help="A place that must be reached from the graph; repeatable.",
)
@click.option("--frame", help="The frame, map or level of the graph that the map shows.")
@click.option(
    "--reach",
    type=POSITIVE,
    help="Distance to the graph within which a place counts as covered; default: 10 radii.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "json", "github"]),
    default="text",
    show_default=True,
    help="The form of the answer; github: annotations for its workflows.",
)
@click.option("--render", type=DRAWING, help="Draw the graph and the findings: FILE.svg or .png.")
@click.option(
    "--repair",
    "repair_file",
    type=OutputType(),
    help="Write the graph, with unsafe nodes moved and unsafe edges led round, in its own format.",
)
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
def command(  # noqa: PLR0913 (an argument for each option of the command line)
    graph_file: Path,
    map_file: Path,
    radius: float,
    keepout: Path | None,
    speed: Path | None,
    speed_filter: tuple[str, float, float],
    max_speed: float | None,
    passing: bool,
    turning_radius: float | None,
    goals: tuple[StationArgument, ...],
    frame: str | None,
    reach: float | None,
    form: str,
    render: Path | None,
    repair_file: Path | None,
    output: Path | None,
) -> int:
    """Audit GRAPH, a route graph of any origin, against a map.

    GRAPH is Nav2's GeoJSON, a LIF (VDA 5050), an Open-RMF navigation graph, GraphML or node-link
    JSON. Its coordinates are the map's. Exits 3 if the graph is unsafe for a robot of this radius,
    or a goal cannot be reached from it. With --repair the repaired graph decides.
    """
    from navigation.cli.pictures.audit_answer import AuditOutput
    from navigation.cli.pictures.sources import compile_for, load_source, read_shades, read_source
    from planner.formats.map_files import decode
    from planner.formats.mask_files import load_mask
    from planner.graph_audit.audit import audit
    from planner.graph_audit.coverage import measure_coverage
    from planner.graph_files.graph_io import graph_text, read_graph
    from planner.graph_repair.repair import repair

    keep_apart(
        (("--output", output), ("--render", render), ("--repair", repair_file)),
        (graph_file, map_file, keepout, speed),
    )
    times_ms = Stopwatch()
    name = str(named(graph_file))
    graph = read_graph(decode(read_source(graph_file), name), name)
    times_ms.end("graph")
    compile_for(map_file)
    times_ms.begin()
    with long_work("reading the map") as begin:
        scene = load_source(map_file)
        zones = None if keepout is None else load_mask(keepout, read_picture=read_shades)
        levels = () if speed is None else _levels(speed, speed_filter)
        times_ms.end("map")
        begin("measuring the edges")
        try:
            found = audit(
                graph,
                scene,
                radius,
                keepout=zones,
                speed=levels,
                max_speed_m_s=max_speed,
                passing=passing,
                turning_radius=turning_radius,
                goals=[goal.as_tuple() for goal in goals],
                frame=frame,
            )
        except ValueError as error:
            raise CommandError(f"{name}: {error}") from error
        coverage = measure_coverage(found, scene, reach)
        times_ms.end("audit")
        repaired = None
        if repair_file is not None:
            begin("repairing the graph")
            repaired = repair(graph, scene, radius, keepout=zones, frame=frame)
            times_ms.end("repair")
            write_text(repair_file, graph_text(repaired.graph, repaired.graph.format))
    if render is not None:
        _save_picture(render, found, scene, zones, levels)
    times_ms.end_all()
    answer = AuditOutput(name, found, coverage, times_ms, scene.remarks, repaired)
    write_text(output, answer.as_form(form))
    if form == "text":
        tell_times(times_ms)
    return 0 if answer.is_safe else UNSAFE


def _save_picture(
    file: Path, found: GraphAudit, scene: Scene, zones: Scene | None, levels: tuple[SpeedLevel, ...]
) -> None:
    from navigation.cli.pictures.audit_picture import audit_drawing
    from navigation.draw.picture import save_drawing

    save_drawing(file, audit_drawing(found, scene, zones, levels))


def _levels(mask: Path, speed_filter: tuple[str, float, float]) -> tuple[SpeedLevel, ...]:
    from navigation.cli.pictures.sources import read_shades
    from planner.formats.mask_files import load_speed_mask

    unit, base, multiplier = speed_filter
    if not math.isfinite(base) or not math.isfinite(multiplier) or multiplier == 0.0:
        raise click.BadParameter(
            f"{base:g} {multiplier:g}: must be finite, and the multiplier not 0",
            param_hint="--speed-filter",
        )
    return load_speed_mask(
        mask,
        percent=unit == "percent",
        base=base,
        multiplier=multiplier,
        read_picture=read_shades,
    )
