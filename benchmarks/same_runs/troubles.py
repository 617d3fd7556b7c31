"""What goes wrong in the runs: with the camera, the line, the robot, the arena, and by people.

Each trouble is a list of steps; most end what they began. Metres, seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from benchmarks.same_runs.script import Do, Scene, Step
from navigation.config import Config
from navigation.config.simulation import SimulatedKnockSection, SimulatedObstacleSection
from navigation.mission.mission import MissionError, Station
from tests.support.runs.troubled_robot import press_estop, switch_off_and_on

GOLDEN: Final = 0.618034
"""Multiples of it, modulo 1, are spread evenly: for a place drawn by a seed."""


def _as_it_is(config: Config) -> Config:
    return config


@dataclass(frozen=True, slots=True)
class Trouble:
    """One thing that goes wrong; ``prepare`` puts into the configuration what belongs there."""

    steps: tuple[Step, ...] = ()
    prepare: Callable[[Config], Config] = _as_it_is
    least_robots: int = 1
    with_pictures: bool = False
    """True for what is driven with drawn pictures too."""
    without_pictures: bool = True
    """False for what only pictures show."""


def _set(part: str, name: str, value: Any, scene: Scene) -> None:
    """Switch one thing of the robot's troubles, or of a camera's."""
    cameras = scene.stage.cameras
    of_camera = cameras[scene.robot % len(cameras)]
    of_robot = scene.stage.bodies[scene.robot].troubles
    setattr(of_camera if part == "camera" else of_robot, name, value)


def _for_a_while(part: str, name: str, value: Any = True, well: Any = False) -> tuple[Step, ...]:
    return Step(partial(_set, part, name, value)), Step(partial(_set, part, name, well))


def _order(name: str, *given: object, to_all: bool = False) -> Do:
    def give(scene: Scene) -> None:
        with suppress(MissionError):  # a person would be told why, and nothing follows
            scene.stage.order(name, None if to_all else scene.robot, *given)

    return give


def _stop_and_resume(stop: Do, *, to_all: bool = False) -> tuple[Step, ...]:
    """A stop, re-armed after a while, and the mission continued."""
    resume = _order("resume", to_all=to_all)
    return Step(stop), Step(resume, 1.0, 3.0), Step(resume, 1.0, 2.0)


def _press_button(scene: Scene) -> None:
    press_estop(scene.stage.bodies[scene.robot])


def _switch_off_and_on(scene: Scene) -> None:
    switch_off_and_on(scene.stage.bodies[scene.robot])


def _carry(most_m: float, scene: Scene) -> None:
    """Somebody lifts the robot and puts it down as far away as chance will have it."""
    body = scene.stage.bodies[scene.robot]
    at, turn = body.pose(), scene.rng.uniform(-math.pi, math.pi)
    away_m = scene.rng.uniform(0.0, most_m)
    place = (at.x_m + away_m * math.cos(turn), at.y_m + away_m * math.sin(turn), turn)
    body.troubles.carried_to = place


def _lay_second_marker(scene: Scene) -> None:
    body = scene.stage.bodies[scene.robot]
    at = body.pose()
    body.troubles.double_at = (at.x_m + 0.3, at.y_m + 0.1, at.heading_rad)


def _swap_markers(scene: Scene) -> None:
    bodies = scene.stage.bodies
    one, other = bodies[scene.robot], bodies[(scene.robot + 1) % len(bodies)]
    one.troubles.marker_at, other.troubles.marker_at = other.pose(), one.pose()


def _swap_back(scene: Scene) -> None:
    for body in scene.stage.bodies:
        body.troubles.marker_at = None


def _new_goal(scene: Scene) -> None:
    """A person sends the robot to where another one is, or it is itself."""
    at = scene.stage.bodies[scene.robot - 1].pose()
    with suppress(MissionError):
        scene.stage.give(scene.robot, (Station(at.x_m, at.y_m),))


def _simulation(config: Config, **changed: Any) -> Config:
    assert config.simulation is not None
    changed = {"simulation": config.simulation.model_copy(update=changed)}
    return config.model_copy(update=changed)


def _with_bucket(config: Config) -> Config:
    """Somebody puts a bucket into the arena and takes it away, its place drawn by the seed."""
    assert config.simulation is not None
    x_min, y_min, x_max, y_max = config.arena.bounds_m
    share = (config.simulation.seed * GOLDEN) % 1.0
    x_m, y_m = x_min + (0.2 + 0.6 * share) * (x_max - x_min), 0.5 * (y_min + y_max)
    record = f"C ({x_m:.3f},{y_m:.3f}) 0.05"
    bucket = SimulatedObstacleSection(record=record, from_s=4.0, until_s=9.0)
    return _simulation(config, obstacles=(*config.simulation.obstacles, bucket))


def _with_knock(config: Config) -> Config:
    assert config.simulation is not None
    knock = SimulatedKnockSection(from_s=3.0, until_s=6.0, tilt_deg=(0.3, 0.0))
    camera = config.simulation.camera.model_copy(update={"knocks": (knock,)})
    return _simulation(config, camera=camera)


def _with_faults(faults: str, config: Config) -> Config:
    assert config.simulation is not None
    robot = config.simulation.robot.model_copy(update={"faults": faults})
    return _simulation(config, robot=robot)


_WAIT: Final = (Step(lambda _scene: None, 9.0, 9.0),)
_NOISY: Final = tuple(
    Step(partial(_set, "camera", name, value), 0.2, most_s)
    for name, value, most_s in (
        ("frozen_noise", True, 3.0),
        ("camera_frozen", True, 0.2),
        ("camera_frozen", False, 3.0),
    )
)
_STOP: Final = _order("stop", "the operator pressed STOP")
_STOP_ALL: Final = _order("stop", "the operator pressed STOP", to_all=True)
_BAD_LINE: Final = "drop=0.002,flip=0.001,noise=0.001,dup=0.05,swap=0.05,span=0.02,stall=0.3@10"

TROUBLES: Final[dict[str, Trouble]] = {
    "none": Trouble(with_pictures=True),
    # the camera
    "hide_marker": Trouble(_for_a_while("robot", "marker_hidden"), with_pictures=True),
    "shift_marker": Trouble(_for_a_while("robot", "marker_shift_m", (0.06, 0.02), (0.0, 0.0))),
    "turn_marker": Trouble(_for_a_while("robot", "marker_turned")),
    "swap_markers": Trouble((Step(_swap_markers), Step(_swap_back)), least_robots=2),
    "second_marker": Trouble(
        (Step(_lay_second_marker), Step(partial(_set, "robot", "double_at", None)))
    ),
    "silence_camera": Trouble(_for_a_while("camera", "camera_silent")),
    "unplug_camera": Trouble(_for_a_while("camera", "camera_lost")),
    "freeze_camera": Trouble(_for_a_while("camera", "camera_frozen"), with_pictures=True),
    "freeze_noisily": Trouble(_NOISY, with_pictures=True, without_pictures=False),
    "loop_camera": Trouble(
        _for_a_while("camera", "looping"), with_pictures=True, without_pictures=False
    ),
    "knock_camera": Trouble(_WAIT, _with_knock, with_pictures=True, without_pictures=False),
    "delay_camera": Trouble(_for_a_while("camera", "stream_latency_s", 0.25, 0.0)),
    "stamp_ahead": Trouble(_for_a_while("camera", "future_s", 0.5, 0.0)),
    # the line
    "cut_cable": Trouble(_for_a_while("robot", "cable_out")),
    "cut_wire_to_robot": Trouble(_for_a_while("robot", "wire_to_robot_cut")),
    "break_port": Trouble(_for_a_while("robot", "port_broken")),
    "bad_line": Trouble(_WAIT, partial(_with_faults, _BAD_LINE)),
    # the robot
    "kill_motors": Trouble(_for_a_while("robot", "motors_dead")),
    "hold_robot_fast": Trouble(_for_a_while("robot", "stuck")),
    "carry_off_the_path": Trouble((Step(partial(_carry, 0.12)),)),
    "carry_away": Trouble((Step(partial(_carry, 1.0)),)),
    "press_the_button": Trouble(_stop_and_resume(_press_button)),
    "switch_off_and_on": Trouble((Step(_switch_off_and_on),)),
    "freeze_processor": Trouble(_WAIT, partial(_with_faults, "freeze=1.5@5")),
    "reset_processor": Trouble(_WAIT, partial(_with_faults, "reset=5")),
    # the arena
    "bucket": Trouble(_WAIT, _with_bucket, with_pictures=True),
    # people
    "stop": Trouble(_stop_and_resume(_STOP)),
    "stop_all": Trouble(_stop_and_resume(_STOP_ALL, to_all=True), least_robots=2),
    "pause": Trouble((Step(_order("pause")), Step(_order("resume")))),
    "replan": Trouble((Step(_order("replan")), Step(_order("replan")))),
    "new_goal": Trouble((Step(_new_goal), Step(_new_goal))),
}
