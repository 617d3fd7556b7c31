"""`clearway replay`: re-runs vision and planning on a recording."""

from __future__ import annotations

import json
import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import POSITIVE, format_option

if TYPE_CHECKING:
    from navigation.recording.reader import Recording
    from navigation.run.replay import ReplayResult

EQUAL, DIFFERENT = 0, 1
MOST_SHOWN = 20


@click.command(short_help="Run vision and planner on a recording; say what differs.")
@click.argument("files", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--pose-mm",
    type=POSITIVE,
    default=3.0,
    show_default=True,
    help="Tolerance of a pose's position.",
)
@click.option(
    "--pose-deg",
    type=POSITIVE,
    default=1.0,
    show_default=True,
    help="Tolerance of a pose's heading.",
)
@click.option(
    "--scene-mm", type=POSITIVE, default=6.0, show_default=True, help="Tolerance of borders."
)
@click.option(
    "--plan-mm", type=POSITIVE, default=30.0, show_default=True, help="Tolerance of paths."
)
@format_option()
def command(
    files: tuple[Path, ...],
    pose_mm: float,
    pose_deg: float,
    scene_mm: float,
    plan_mm: float,
    form: str,
) -> int:
    """Re-run vision and planning on recordings (FILES, of `clearway run --record`).

    Pictures and requests go through the same vision and planner, with the recorded configuration.
    Poses, scenes and plans are compared with the recorded ones; the options set the tolerances.
    Exits 0 when all are equal, 1 when something differs.
    """
    from navigation.recording.compare import ComparisonTolerances
    from navigation.recording.reader import read_recording
    from navigation.run.replay import replay

    limits = ComparisonTolerances(
        position_m=pose_mm / 1e3,
        heading_rad=math.radians(pose_deg),
        scene_m=scene_mm / 1e3,
        path_m=plan_mm / 1e3,
    )
    code = EQUAL
    for file in files:
        recording = read_recording(file)
        result = replay(recording, limits)
        code = code if result.is_equal else DIFFERENT
        if form == "json":
            click.echo(json.dumps(_as_object(recording, result), allow_nan=False))
        else:
            _show(recording, result)
    return code


def _as_object(recording: Recording, result: ReplayResult) -> dict[str, object]:
    return {
        "schema": "clearway.replay/1",
        "file": str(recording.path),
        "recorded_by": recording.version,
        "cut": recording.cut,
        "status": "equal" if result.is_equal else "different",
        **asdict(result),
    }


def _show(recording: Recording, result: ReplayResult) -> None:
    cut = ", a file without an end" if recording.cut else ""
    click.echo(
        f"{recording.path}: {result.pictures} pictures{cut}; compared {result.poses} poses, "
        f"{result.scenes} scenes, {result.plans} plans"
    )
    far = result.largest
    click.echo(
        f"  at most {far.position_m * 1e3:.2f} mm and {math.degrees(far.heading_rad):.2f} deg "
        f"apart; borders {far.scene_m * 1e3:.2f} mm, paths {far.path_m * 1e3:.2f} mm"
    )
    if result.not_compared:
        click.echo(f"  {result.not_compared} scenes or plans have no pictures to compare with")
    if result.near_ties:
        click.echo(
            f"  {result.near_ties} plans take another route that is as good in the same scene"
        )
    for difference in result.differences[:MOST_SHOWN]:
        click.echo(f"  {difference.time_s:.3f} s  {difference.sentence}")
    if len(result.differences) > MOST_SHOWN:
        click.echo(f"  and {len(result.differences) - MOST_SHOWN} more")
    click.echo("  equal" if result.is_equal else f"  {len(result.differences)} differences")
