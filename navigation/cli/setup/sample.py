"""`clearway sample`: a picture or a map to try."""

from __future__ import annotations

from pathlib import Path

import click

from navigation.cli.outputs import write_bytes
from planner.samples.sample import SAMPLES, sample_files

NEXT = {
    "arena": "plan {file} --start 40,40 --goal 600,440 --radius 20 --render plan.svg",
    "photograph": "plan {file} --start 40,440 --goal 600,40 --radius 18 --render plan.svg",
    "maze": "plan {file} --start 20,20 --goal 620,460 --radius 9 --render plan.svg",
    "rooms": "plan {file} --start=-1,1 --goal 5.5,2.5 --radius 0.22 --render plan.svg",
}


@click.command(short_help="A picture or a map to try things with.")
@click.argument("name", type=click.Choice(tuple(SAMPLES)), metavar="NAME")
@click.option(
    "--into",
    type=click.Path(path_type=Path, file_okay=False, exists=True),
    default=Path("."),
    metavar="FOLDER",
    help="Where to put it.  [default: the present folder]",
)
@click.option("--force", is_flag=True, help="Overwrite an existing file.")
def command(name: str, into: Path, force: bool) -> None:
    """Write the sample NAME: the picture arena, photograph or maze, or the ROS map rooms."""
    files = [(file, into / file.name) for file in sample_files(name)]
    there = [copy for _, copy in files if copy.exists()]
    if there and not force:
        raise click.UsageError(f"{there[0]} exists; --force overwrites it")
    for file, copy in files:
        write_bytes(copy, file.read_bytes())
    first = files[0][1]
    click.echo(f"wrote {first}; next: clearway {NEXT[name].format(file=first)}")
