"""`clearway audit`: a route graph against a map: exact clearances, and what is wrong with it."""

from __future__ import annotations

import time
from pathlib import Path

import click

from navigation.cli.options import (
    DRAWING,
    INPUT,
    OUTPUT,
    RADIUS_OPTION,
    STANDARD_STREAM,
    STATION,
    StationArgument,
)
from navigation.cli.outputs import keep_apart, named, tell_times, write_text
from navigation.cli.progress import long_work

UNSAFE = 3
"""Exit code, the same as for no path."""


class AuditError(ValueError):
    """The request makes no sense; the message says why."""


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
@click.option(
    "--goal",
    "goals",
    type=STATION,
    multiple=True,
    help="A place that must be reached from the graph; repeatable.",
)
@click.option("--frame", help="The frame, map or level of the graph that the map shows.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "json", "github"]),
    default="text",
    show_default=True,
    help="The form of the answer; github: annotations for its workflows.",
)
@click.option("--render", type=DRAWING, help="Draw the graph and the findings: FILE.svg or .png.")
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
def command(
    graph_file: Path,
    map_file: Path,
    radius: float,
    keepout: Path | None,
    goals: tuple[StationArgument, ...],
    frame: str | None,
    form: str,
    render: Path | None,
    output: Path | None,
) -> int:
    """Audit GRAPH, a route graph of any origin, against a map.

    GRAPH is Nav2's GeoJSON, a LIF (VDA 5050), an Open-RMF navigation graph, GraphML or node-link
    JSON. Its coordinates are the map's. Exits 3 if the graph is unsafe for a robot of this radius,
    or a goal cannot be reached from it.
    """
    from navigation.cli.pictures.audit_answer import AuditOutput
    from navigation.cli.pictures.sources import compile_for, load_source, read_shades, read_source
    from planner.formats.map_files import decode
    from planner.formats.mask_files import load_mask
    from planner.graph_audit.audit import audit
    from planner.graph_files.graph_io import read_graph

    inputs = (graph_file, map_file, keepout)
    if inputs.count(STANDARD_STREAM) > 1:
        raise click.UsageError("-: only one of GRAPH, --map and --keepout can be standard input")
    keep_apart((("--output", output), ("--render", render)), inputs)
    begin_s = time.perf_counter()
    name = str(named(graph_file))
    graph = read_graph(decode(read_source(graph_file), name), name)
    timings_ms = {"graph": 1e3 * (time.perf_counter() - begin_s)}
    compile_for(map_file)
    map_s = time.perf_counter()
    with long_work("reading the map") as begin:
        scene = load_source(map_file)
        zones = None if keepout is None else load_mask(keepout, read_picture=read_shades)
        timings_ms["map"] = 1e3 * (time.perf_counter() - map_s)
        begin("measuring the edges")
        audit_s = time.perf_counter()
        try:
            found = audit(
                graph,
                scene,
                radius,
                keepout=zones,
                goals=[goal.as_tuple() for goal in goals],
                frame=frame,
            )
        except ValueError as error:
            raise AuditError(f"{name}: {error}") from error
        timings_ms["audit"] = 1e3 * (time.perf_counter() - audit_s)
    if render is not None:
        from navigation.cli.pictures.audit_picture import audit_drawing
        from navigation.draw.picture import save_drawing

        save_drawing(render, audit_drawing(found, scene, zones))
    timings_ms["total"] = 1e3 * (time.perf_counter() - begin_s)
    answer = AuditOutput(name, found, timings_ms, scene.remarks)
    write_text(output, answer.as_form(form))
    if form == "text":
        tell_times(timings_ms)
    lost = any(one.kind == "goal_unreachable" for one in found.findings)
    return UNSAFE if lost or not found.safe else 0
