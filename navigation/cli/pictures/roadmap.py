"""`clearway roadmap`: the AGVD roadmap as a file."""

from __future__ import annotations

import json
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path

import click

from navigation.cli.options import (
    DRAWING,
    INPUT,
    LEAST_AREA_OPTION,
    NOT_NEGATIVE,
    POSITIVE,
    RADIUS_OPTION,
    SPACING_OPTION,
    STANDARD_STREAM,
    ZONES_OPTION,
    Binarising,
    OutputType,
    binarise_options,
    check_spacing,
)
from navigation.cli.outputs import Stopwatch, keep_apart, warn_of_doubts, write_text
from navigation.cli.progress import long_work
from planner.graph_files import SUFFIXES


@click.command(short_help="The AGVD roadmap as a file.")
@click.argument("source", type=INPUT)
@RADIUS_OPTION
@click.option(
    "-o",
    "--output",
    type=OutputType(*SUFFIXES, stream=True),
    required=True,
    help="FILE.graphml, .json (node-link, also for -), .geojson (Nav2's route server), .lif (LIF,"
    " for VDA 5050) or .yaml (Open-RMF).",
)
@SPACING_OPTION
@ZONES_OPTION
@binarise_options
@LEAST_AREA_OPTION
@click.option(
    "--least-branch",
    type=NOT_NEGATIVE,
    default=0.0,
    metavar="LENGTH",
    help="Leave out dead ends shorter than this, in the scene's units.",
)
@click.option("--frame", default="map", show_default=True, help="Frame of .geojson, .lif, .yaml.")
@click.option(
    "--map",
    "map_file",
    type=OutputType(".yaml", ".yml"),
    help="Write the obstacles as a ROS map too: FILE.yaml, and FILE.pgm beside it.",
)
@click.option(
    "--resolution", type=POSITIVE, default=0.05, show_default=True, help="Of that map, in metres."
)
@click.option("--render", type=DRAWING, help="Draw the roadmap: FILE.svg or FILE.png.")
def command(  # noqa: PLR0913 (an argument for each option of the command line)
    source: Path,
    radius: float,
    output: Path,
    spacing: float | None,
    zones_file: Path | None,
    binarising: Binarising,
    least_area: float | None,
    least_branch: float,
    frame: str,
    map_file: Path | None,
    resolution: float,
    render: Path | None,
) -> None:
    """Build the roadmap of SOURCE and write it; the output's suffix gives the format."""
    check_spacing(spacing, radius)
    inputs = (source, zones_file)
    keep_apart((("--output", output), ("--map", map_file), ("--render", render)), inputs)

    from navigation.cli.pictures.plan import timed_roadmap
    from navigation.cli.pictures.sources import compile_for, load_source, zones_in
    from planner.graph_files.graph_io import format_of, graph_text
    from planner.roadmap.roadmap_export import route_graph
    from planner.zones.ruled_graph import ruled_graph
    from planner.zones.zoned_roadmap import with_zones

    zones = zones_in(zones_file)
    compile_for(source)
    with long_work("looking for obstacles"):
        scene = load_source(source, binarising, least_area)
    warn_of_doubts(scene, source)
    with long_work("building the roadmap"):
        roadmap = timed_roadmap(scene, radius, spacing, Stopwatch(), least_branch)
    now = datetime.now(UTC).isoformat(timespec="seconds")
    suffix = ".json" if output == STANDARD_STREAM else output.suffix
    form = format_of(f"roadmap{suffix}")
    zoned = with_zones(roadmap, zones)
    graph = ruled_graph(route_graph(zoned.closed, form, frame, now), zoned.rules)
    text = graph_text(graph, form)
    write_text(output, text)
    if map_file is not None:
        from planner.formats.map_writer import write_map

        write_map(scene, map_file, resolution)
    if render is not None:
        from navigation.draw import save_picture

        save_picture(render, scene, roadmap=zoned.closed, zones=zones)
    counts = zoned.closed.counts
    to_stream = output == STANDARD_STREAM
    name = "roadmap" if to_stream else output
    parts = f"{counts['roadmap_nodes']} nodes, {counts['roadmap_edges']} edges"
    if output.suffix.lower() == ".geojson":
        kinds = Counter(one["geometry"]["type"] for one in json.loads(text)["features"])
        parts = (
            f"{kinds['Point']} points, {kinds.total() - kinds['Point']} lines, one in each"
            f" direction, of {parts}"
        )
    click.echo(f"{name}: {parts}, robot radius {radius:g} {scene.units}", err=to_stream)
    if suffix.lower() not in (".json", ".graphml") and scene.units != "m":
        click.echo(
            f"note: Nav2, LIF and Open-RMF take coordinates as metres, y up: these are"
            f" {scene.units}, y down, and fit frame '{frame}' only once they are converted"
        )
    for remark in (*scene.remarks, *roadmap.remarks):
        click.echo(f"note: {remark}", err=to_stream)
