"""`clearway fleet`: several robots' paths."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import click

from navigation.cli.options import (
    DRAWING,
    INPUT,
    OUTPUT,
    ZONES_OPTION,
    Binarising,
    binarise_options,
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
    from navigation.cli.pictures.fleet_robots import FleetRobot
    from planner.fleet.fleet_plan import NoFleetPlan
    from planner.roadmap.roadmap import Roadmap
    from planner.zones.zone import Zone

NO_PLAN = 3
"""Exit code, the same as for no path."""


@click.command(short_help="Paths for several robots, none of which touch.")
@click.argument("source", type=INPUT)
@click.option(
    "--robots",
    "robots_file",
    type=INPUT,
    required=True,
    help="CSV or JSON: name, start_x, start_y, goal_x, goal_y, radius.",
)
@click.option(
    "--time-limit",
    "time_limit_s",
    type=click.FloatRange(min=0.0, min_open=True),
    default=30.0,
    show_default=True,
    help="Seconds of search at most.",
)
@click.option(
    "--assign",
    type=click.Choice(("sum", "last")),
    help="Give each goal to the robot that suits: least sum of driving times, or last arrival.",
)
@ZONES_OPTION
@binarise_options
@format_option()
@click.option("--render", type=DRAWING, help="Draw the plan: FILE.svg, animated, or FILE.png.")
@click.option("-o", "--output", type=OUTPUT, help="Write the answer to this file.")
def command(
    source: Path,
    robots_file: Path,
    time_limit_s: float,
    assign: Literal["sum", "last"] | None,
    zones_file: Path | None,
    binarising: Binarising,
    form: str,
    render: Path | None,
    output: Path | None,
) -> int:
    """Plan several robots through SOURCE: a picture, a scene, a ROS map's YAML or a .map.

    Every robot drives a diameter a second or stands still, as clearway plan assumes without other
    limits. With --assign any robot may take any goal, so that the sum of the driving times, or the
    longest of them, is least. Exits 3 if there is no plan, and says why and because of which
    robots.
    """
    from navigation.cli.pictures.fleet_answer import FleetOutput
    from navigation.cli.pictures.fleet_picture import drawn_robots
    from navigation.cli.pictures.fleet_robots import load_robots
    from navigation.cli.pictures.plan import timed_roadmap
    from navigation.cli.pictures.sources import compile_for, hold_points, load_source, zones_in
    from planner.fleet.fleet_plan import FleetPlan, NoFleetPlan
    from planner.fleet.on_roadmap import plan_fleet
    from planner.zones.zone import zones_for

    keep_apart((("--output", output), ("--render", render)), (source, robots_file, zones_file))
    robots = load_robots(robots_file)
    zones = zones_in(zones_file)
    compile_for(source)
    times_ms = Stopwatch()
    with long_work("looking for obstacles"):
        scene = load_source(source, binarising)
    warn_of_doubts(scene, source)
    radii = [robot.radius for robot in robots]
    stations = [robot.start for robot in robots] + [robot.goal for robot in robots]
    scene = hold_points(scene, stations, 4.0 * max(radii))
    with long_work("building the roadmap") as begin:
        roadmap = timed_roadmap(scene, min(radii), None, times_ms)
        begin("planning")
        try:
            found = robots if assign is None else _assigned(roadmap, robots, assign, zones)
            if isinstance(found, NoFleetPlan):
                plan: FleetPlan | NoFleetPlan = found
            else:
                robots = found
                starts, goals = [r.start for r in robots], [r.goal for r in robots]
                own = [zones_for(zones, robot.name) for robot in robots]
                plan = plan_fleet(
                    roadmap, starts, goals, radii, time_limit_s=time_limit_s, zones=own
                )
        except ValueError as error:
            raise CommandError(f"{robots_file}: {error}") from error
        times_ms.end("fleet")
    times_ms.end_all()
    remarks = (*scene.remarks, *roadmap.remarks)
    if isinstance(plan, FleetPlan):
        remarks += plan.remarks
    answer = FleetOutput(scene.units, robots, plan, times_ms, remarks)
    text = answer.as_json() + "\n" if form == "json" else answer.as_text()
    write_text(output, text)
    if form == "text":
        tell_times(times_ms)
    if not isinstance(plan, FleetPlan):
        click.echo(f"clearway: no plan: {answer.sentence()}", err=True)
        return NO_PLAN
    if render is not None:
        from navigation.draw import save_picture

        save_picture(render, scene, driven=drawn_robots(robots, plan), zones=zones, title="Fleet")
    return 0


def _assigned(
    roadmap: Roadmap,
    robots: list[FleetRobot],
    objective: Literal["sum", "last"],
    zones: tuple[Zone, ...],
) -> list[FleetRobot] | NoFleetPlan:
    """The robots with their goals exchanged; one that can reach none gets one of the rest."""
    import numpy as np

    from planner.fleet.assignment import assign_tasks
    from planner.fleet.fleet_plan import NoFleetPlan
    from planner.shared.figures import placed
    from planner.zones.zone import zones_for

    starts, goals = [r.start for r in robots], [r.goal for r in robots]
    found = assign_tasks(
        roadmap, starts, goals, [r.radius for r in robots], objective=objective,
        zones=[zones_for(zones, robot.name) for robot in robots],
    )  # fmt: skip
    reached = np.isfinite(found.durations_s)
    for task in found.left_over:
        if not reached[:, task].any():
            why = _refusal(roadmap, robots[0], goals[task], zones)
            return NoFleetPlan(f"no robot reaches the goal {placed(*goals[task])}; {why}")
        if reached.any(axis=1).all():
            needed = "each that reaches it is needed for another"
            return NoFleetPlan(f"no robot is left for the goal {placed(*goals[task])}: {needed}")
    left = iter(found.left_over)
    return [
        replace(robot, goal=goals[next(left) if task is None else task])
        for robot, task in zip(robots, found.tasks, strict=True)
    ]


def _refusal(
    roadmap: Roadmap, robot: FleetRobot, goal: tuple[float, float], zones: tuple[Zone, ...]
) -> str:
    """Reason why this robot does not reach a goal, with its name."""
    from planner.fleet.fleet_plan import NoFleetPlan
    from planner.fleet.on_roadmap import plan_fleet
    from planner.zones.zone import zones_for

    own = zones_for(zones, robot.name)
    alone = plan_fleet(roadmap, [robot.start], [goal], [robot.radius], zones=[own])
    assert isinstance(alone, NoFleetPlan), "it has no path in the table of costs"
    return f"{robot.name}: {alone.reason.removeprefix('robot 0: ')}"
