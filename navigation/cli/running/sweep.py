"""`clearway sweep`: a simulated run, many times."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from navigation.cli.options import NOT_NEGATIVE, OutputType, format_option

if TYPE_CHECKING:
    from navigation.config import Config
    from navigation.sweep.table import Summary

ALL_DONE, SOME_NOT_DONE = 0, 1


@click.command(short_help="Repeat a simulated run with varied errors.")
@click.argument("config", type=click.Path(path_type=Path))
@click.option("--runs", type=click.IntRange(min=1), required=True, help="How many runs.")
@click.option(
    "--seed",
    type=click.IntRange(min=0),
    default=0,
    show_default=True,
    help="Seed of the whole sweep.",
)
@click.option(
    "--spread",
    type=NOT_NEGATIVE,
    default=1.0,
    show_default=True,
    help="How far errors and start vary, up to 16; 0: other seeds only.",
)
@click.option(
    "--pictures/--no-pictures",
    default=True,
    show_default=True,
    help="Draw what the camera sees; without, the simulation supplies what vision would find, "
    "which is faster.",
)
@click.option(
    "--workers", type=click.IntRange(min=1), help="Processes; default: one for each core."
)
@click.option("--scheduler", metavar="ADDRESS", help="A Dask cluster's scheduler, tcp://...")
@click.option(
    "-o",
    "--output",
    type=OutputType(".csv", ".parquet"),
    default=Path("sweep.csv"),
    show_default=True,
    help="The table, one row for each run.",
)
@format_option()
def command(
    config: Path,
    runs: int,
    seed: int,
    spread: float,
    pictures: bool,
    workers: int | None,
    scheduler: str | None,
    output: Path,
    form: str,
) -> int:
    """Repeat the simulated configuration CONFIG in virtual time, as fast as the machine can.

    Each run has another seed, another start nearby, other wheels and another camera's noise; the
    same seed gives the same rows. Several robots have a row each for every run, with the name and
    the least gap between any two. A worker that dies is replaced. With `--no-pictures` the camera's
    blur and light have no effect, and anything that only pictures show is refused. Exits 0 when
    every mission was done, 1 when some were not.
    """
    from rich.console import Console
    from rich.progress import track

    from navigation.cli.setup.check import load_checked
    from navigation.config.known_robots import CLEARWAY
    from navigation.config.several.each_robot import robots_of, settled
    from navigation.sweep.runs import COLUMNS, FLEET_COLUMNS, IDLE, Sweep, run_rows
    from navigation.sweep.table import SweepFile, summarise_rows
    from navigation.sweep.variations import variation

    loaded = settled(load_checked(config.absolute()))
    for one in robots_of(loaded).values():
        if one.robot.driver != CLEARWAY:
            raise click.UsageError(
                f"{config}: robot.driver {one.robot.driver} drives in real time only; "
                f"a sweep needs {CLEARWAY}"
            )
    if not pictures:
        _refuse_what_only_pictures_show(config, loaded)
    several = len(loaded.robots)
    chosen = [variation(loaded, seed, run, spread) for run in range(runs)]
    open_executor, count = _executors(loaded, scheduler, workers)
    sweep = Sweep(loaded, chosen, open_executor, count, partial(run_rows, pictures=pictures))
    begin_s = time.monotonic()
    with SweepFile(output, FLEET_COLUMNS if several else COLUMNS) as file:
        console = Console(stderr=True)
        silent = not console.is_terminal
        rows = runs * max(1, several)
        for row in track(sweep.rows(), "runs", rows, console=console, disable=silent):
            file.add(row)
    took_s = time.monotonic() - begin_s
    summary = summarise_rows(file.rows)
    if form == "json":
        body = {"schema": "clearway.sweep/1", "file": str(output), **asdict(summary)}
        click.echo(json.dumps({**body, "took_s": took_s, "worker_deaths": sweep.deaths}, indent=1))
    else:
        _show(summary, output, took_s, sweep.deaths)
    return ALL_DONE if summary.states.keys() - {IDLE} == {"done"} else SOME_NOT_DONE


def _refuse_what_only_pictures_show(path: Path, config: Config) -> None:
    from navigation.run.without_pictures.looking import looking_of
    from navigation.simulator.arena import load_arena
    from navigation.simulator.happenings import arenas_over_time

    try:
        looking_of(config, arenas_over_time(config, load_arena(config)), pictures=False)
    except ValueError as error:
        raise click.UsageError(f"{path}: {error}") from None


def _executors(
    config: Config, scheduler: str | None, workers: int | None
) -> tuple[Callable[[], Executor], int]:
    if scheduler is None:
        from navigation.run.kernels.warm_up import kernels_are_cold, warm_up
        from navigation.sweep.workers import local_executor

        count = workers or os.cpu_count() or 1
        if kernels_are_cold():  # once here, not in every worker at the same time
            warm_up(config, lambda line: click.echo(line, err=True))
        return lambda: local_executor(count), count
    from navigation.sweep.workers import Cluster

    cluster = Cluster(scheduler)
    return cluster.executor, workers or cluster.workers()


def _show(summary: Summary, output: Path, took_s: float, deaths: int) -> None:
    states = ", ".join(f"{count} {state}" for state, count in summary.states.items())
    click.echo(f"{summary.runs} runs in {took_s:.1f} s: {states}")
    if deaths:
        click.echo(f"workers died {deaths} times and were replaced")
    click.echo(f"{'':<18}{'least':>10}{'median':>10}{'p95':>10}{'most':>10}")
    for name, spread in summary.measures.items():
        values = (spread.least, spread.median, spread.p95, spread.most)
        click.echo(f"{name:<18}" + "".join(f"{value:>10.4g}" for value in values))
    click.echo(f"rows in {output}")
