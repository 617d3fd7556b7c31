"""The README's moving picture: a run of the simulated arena, as an SVG that plays by itself.

`python -m benchmarks.figures.film [--output docs/pictures/run.svg]`

Drives configs/simulation.yaml in virtual time, with real vision, planning and serial link, and
draws what `navigation.draw` draws, with the robot moving along its true track. SMIL, without
scripts: browsers play it in an `img` too. The same seed gives the same picture.
"""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from navigation.config import load_config
from navigation.draw import draw_svg
from navigation.draw.picture import MARGIN, PLOT_HEIGHT, PLOT_WIDTH
from navigation.draw.shapes import Screen, fit_screen
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.run.summary import driven_track
from navigation.run.virtual_run import FIRST_MISSION_ID
from navigation.run.virtual_world import VirtualWorld
from planner.path import Path as PlannedPath
from planner.roadmap.roadmap import Roadmap
from planner.scene import FloatArray, Scene

CONFIG = Path(__file__).parents[2] / "configs/simulation.yaml"
STEP_S = 0.15
"""Between two shown poses: browsers interpolate, and 1 cm of a bend at 0.3 m/s is no corner."""
SPEED_UP = 3.0
"""A run of half a minute in ten seconds: what a reader waits for."""
REST_S = 1.5
"""How long the end is shown before it begins again."""
MOST_BYTES = 300 * 1024


@dataclass(frozen=True)
class Film:
    """What is shown: ``track`` (n, 4) of seconds, x_m, y_m, heading_rad; plans with their start."""

    scene: Scene
    roadmap: Roadmap
    plans: list[tuple[float, PlannedPath]]
    track: FloatArray
    stations: list[tuple[float, ...]]
    radius_m: float


def drive(config_file: Path = CONFIG) -> Film:
    """Drive the configured mission in virtual time."""
    config = load_config(config_file, {})
    world = VirtualWorld(config)
    with Daemon(config, world, first_mission_id=FIRST_MISSION_ID) as daemon:
        stations = stations_of(config)
        daemon.people.give(stations, any_order=config.mission.order == "best")
        while not (now := daemon.cycle().only).mission.is_over:
            pass
        if now.mission.state.value != "done":
            raise RuntimeError(f"the run was not done: {now.sentence}")
        assert daemon.scene is not None
        assert daemon.roadmap is not None
        places = [
            (s.x, s.y) if s.heading_rad is None else (s.x, s.y, s.heading_rad) for s in stations
        ]
        track = driven_track(daemon, daemon.robot)
        first = (float(track[0, 1]), float(track[0, 2]))
        return Film(
            daemon.scene,
            daemon.roadmap,
            [(plan.since_s, plan.path) for plan in daemon.robot.plans],
            track,
            [first, *places],
            config.robot.radius_m,
        )


def film_svg(film: Film) -> str:
    """The picture: the still of ``navigation.draw``, and above it what moves."""
    still = draw_svg(film.scene, film.roadmap, stations=film.stations, title="A run of Clearway")
    b = film.scene.bounds
    screen = fit_screen(b, film.scene.y_down, PLOT_WIDTH, PLOT_HEIGHT, MARGIN, MARGIN)
    moving = "\n".join(
        ['<g clip-path="url(#view)">', *_plans(film, screen), *_robot(film, screen), "</g>"]
    )
    return still.replace("</svg>", f"{moving}\n</svg>")


def _duration_s(film: Film) -> float:
    return float(film.track[-1, 0] - film.track[0, 0]) / SPEED_UP + REST_S


def _moment(film: Film, time_s: float) -> float:
    """A time of the run as a part of the film."""
    at = (time_s - float(film.track[0, 0])) / SPEED_UP / _duration_s(film)
    return min(max(at, 0.0), 1.0)


def _plans(film: Film, screen: Screen) -> list[str]:
    """Each plan with the strip that the robot sweeps, from its start to the next one's."""
    drawn = []
    starts = [since_s for since_s, _ in film.plans]
    for number, (since_s, path) in enumerate(film.plans):
        begin = _moment(film, since_s) if number else 0.0
        end = _moment(film, starts[number + 1]) if number + 1 < len(starts) else 1.0
        if end <= begin:
            continue
        width = 2.0 * film.radius_m * screen.scale
        line = _line(screen.points(path.points))
        on = (
            f'<animate attributeName="opacity" calcMode="discrete" values="0;1;0;0"'
            f' keyTimes="0;{begin:.4f};{end:.4f};1" dur="{_duration_s(film):.2f}s"'
            ' repeatCount="indefinite"/>'
        )
        if end >= 1.0:
            on = on.replace('values="0;1;0;0"', 'values="0;1"')
            on = on.replace(f'keyTimes="0;{begin:.4f};{end:.4f};1"', f'keyTimes="0;{begin:.4f}"')
        if begin == 0.0:
            on = on.replace('values="0;1', 'values="1;1')
        drawn.append(
            f'<g fill="none"><path d="{line}" stroke="#0f7b45" stroke-opacity="0.15"'
            f' stroke-width="{width:.1f}"/>'
            f'<path d="{line}" stroke="#0f7b45" stroke-width="2.5"/>{on}</g>'
        )
    return drawn


def _robot(film: Film, screen: Screen) -> list[str]:
    """The robot as a disc with its heading, and the track behind it."""
    begin_s, end_s = float(film.track[0, 0]), float(film.track[-1, 0])
    times = np.linspace(begin_s, end_s, max(2, math.ceil((end_s - begin_s) / STEP_S)))
    columns = [np.interp(times, film.track[:, 0], film.track[:, k]) for k in (1, 2)]
    turned = np.interp(times, film.track[:, 0], np.unwrap(film.track[:, 3]))
    xy = screen.points(np.column_stack(columns))
    degrees = np.degrees([screen.heading(one) for one in turned.tolist()])
    moments = [*(_moment(film, one) for one in times.tolist()), 1.0]
    keys = ";".join(f"{one:.4f}" for one in moments)
    lengths = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))))
    left = 1.0 - lengths / lengths[-1]

    def animate(tag: str, values: list[str]) -> str:
        joined = ";".join([*values, values[-1]])
        return (
            f'<{tag} values="{joined}" keyTimes="{keys}" dur="{_duration_s(film):.2f}s"'
            ' repeatCount="indefinite"/>'
        )

    places = [f"{x:.1f},{y:.1f}" for x, y in xy.tolist()]
    radius = film.radius_m * screen.scale
    moves = animate('animateTransform attributeName="transform" type="translate"', places)
    turns = animate(
        'animateTransform attributeName="transform" type="rotate"',
        [f"{one:.0f}" for one in degrees.tolist()],
    )
    tail = animate(
        'animate attributeName="stroke-dashoffset"', [f"{one:.4f}" for one in left.tolist()]
    )
    return [
        f'<path d="{_line(xy)}" fill="none" stroke="#7a3fb5" stroke-width="3" pathLength="1"'
        ' stroke-dasharray="1 1" stroke-dashoffset="1" stroke-linecap="butt">'
        f"{tail}</path>",
        f'<g transform="translate({places[0]})">{moves}<g>{turns}'
        f'<circle r="{radius:.1f}" fill="#7a3fb5" fill-opacity="0.85" stroke="#fff"'
        ' stroke-width="2"/>'
        f'<path d="M0,0H{radius:.1f}" stroke="#fff" stroke-width="4"/></g></g>',
    ]


def _line(points: FloatArray) -> str:
    return "M" + "L".join(f"{x:.1f},{y:.1f}" for x, y in points.tolist())


def main() -> None:
    """Drive, draw and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=Path("docs/pictures/run.svg"))
    file: Path = parser.parse_args().output
    text = film_svg(drive())
    if len(text) > MOST_BYTES:
        raise RuntimeError(f"{file}: {len(text)} bytes: must be at most {MOST_BYTES}")
    file.write_text(text, encoding="utf-8")
    print(f"{file}: {len(text) / 1024:.0f} KiB")


if __name__ == "__main__":
    main()
