"""Every row of the safety table, broken in the running daemon in virtual time.

Each test lets the robot drive, breaks one thing, and wants the permit gone within one cycle of
the moment at which the daemon can know, the robot standing soon after, and the sentence.
Where the pictures say what is broken, they are drawn too; that all else is decided alike with them
is what `tests/navigation/run/without_pictures/test_both_kinds.py` says.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from firmware_protocol.host.events import LinkChanged, RobotRebooted
from firmware_protocol.host.state import LinkState
from firmware_protocol.wire.messages import ResetCause
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from navigation.simulator.line_faults import FaultSpec
from planner.scene import Scene
from tests.support.runs.troubled_robot import press_estop
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, is_driving, set_trouble, short_config

pytestmark = pytest.mark.slow

FAR = [{"x_m": 0.20, "y_m": 1.60}]
FRAME_S = 1 / 30
"""Half as long as between two pictures here: the bounds are those of a camera of 30 Hz."""
CYCLE_S = 0.05
"""The longest cycle: without a frame."""
BRAKING_S = 0.3 / 0.5
LEASE_S = 0.5
DRIVE_LAG_S = 0.05
"""The simulated wheels follow with a delay: below a centimetre a second they fade away."""
HIGH_CAMERA = {
    "position_m": (1.155, 0.975, 2.9), "focal_px": 617.5, "centre_offset_px": (2.6, -1.9)
}  # fmt: skip
"""So high that it sees a robot outside the arena too."""


@dataclass(frozen=True, slots=True)
class Arena:
    """A daemon whose robot drives, and its world."""

    world: TroubledWorld
    daemon: Daemon

    def until(self, state: State, seconds: float = 5.0) -> RobotSnapshot:
        return cycle_until(self.daemon, lambda now: now.mission.state is state, seconds)

    def stands(self) -> bool:
        return not self.world.body.loop.drive.moving


@pytest.fixture
def arena(request: pytest.FixtureRequest) -> Iterator[Arena]:
    """A robot that drives; with drawn pictures where the parameter is ``True``."""
    config = short_config(
        FAR, simulation={"camera": HIGH_CAMERA}, camera={"rate_hz": 0.5 / FRAME_S}
    )
    world = TroubledWorld(config, pictures=getattr(request, "param", False))
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        cycle_until(daemon, lambda _: world.body.loop.drive.moving)
        yield Arena(world, daemon)


drawn = pytest.mark.parametrize("arena", [True], ids=["drawn"], indirect=True)
"""Only the pictures show it."""


def hide_marker(arena: Arena) -> None:
    arena.world.body.troubles.marker_hidden = True


def silence_camera(arena: Arena) -> None:
    arena.world.cameras[None].camera_silent = True


def freeze_camera(arena: Arena) -> None:
    arena.world.cameras[None].camera_frozen = True


def unplug_camera(arena: Arena) -> None:
    arena.world.cameras[None].camera_lost = True


def cut_cable(arena: Arena) -> None:
    arena.world.body.troubles.cable_out = True


def break_port(arena: Arena) -> None:
    arena.world.body.troubles.port_broken = True


def freeze_robot(arena: Arena) -> None:
    arena.world.body.loop.knobs.frozen = True


def carry_outside(arena: Arena) -> None:
    arena.world.body.troubles.carried_to = (-0.05, 0.9, 0.0)


def carry_into_an_obstacle(arena: Arena) -> None:
    arena.world.body.troubles.carried_to = (0.42, 1.05, 0.0)


def carry_near_an_obstacle(arena: Arena) -> None:
    arena.world.body.troubles.carried_to = (0.225, 1.16, math.pi / 2)


def carry_off_the_path(arena: Arena) -> None:
    x, y, heading = arena.world.body.pose()
    arena.world.body.troubles.carried_to = (x + 0.07, y, heading)


def press_the_button(arena: Arena) -> None:
    press_estop(arena.world.body)


def press_pause(arena: Arena) -> None:
    arena.daemon.people.pause()


def press_stop(arena: Arena) -> None:
    arena.daemon.people.stop("the operator pressed STOP")


TABLE: list[tuple[Callable[[Arena], None], State, float, str]] = [
    # what is broken, the state, after how long at most the daemon can know, the sentence
    (hide_marker, State.HOLDING, 0.2 + FRAME_S, "the robot's marker was not seen for"),
    (silence_camera, State.HOLDING, 0.2 + FRAME_S, "no picture from the camera for"),
    (freeze_camera, State.HOLDING, 0.2 + FRAME_S, "no picture from the camera for"),
    (unplug_camera, State.HOLDING, 0.2 + FRAME_S, "no picture from the camera for"),
    (cut_cable, State.HOLDING, 0.5 + FRAME_S, "the link to the robot is down"),
    (break_port, State.HOLDING, FRAME_S, "the link to the robot is down: the port virtual broke"),
    (carry_outside, State.STOPPED, 3 * FRAME_S, "the robot is outside the arena at (-0.0"),
    (carry_into_an_obstacle, State.STOPPED, 3 * FRAME_S, "the robot's clearance is -0.0"),
    (carry_near_an_obstacle, State.STOPPED, 3 * FRAME_S, "the robot's clearance is 0.06"),
    (carry_off_the_path, State.HOLDING, 3 * FRAME_S, "m off its path"),
    (
        press_the_button,
        State.STOPPED,
        0.1 + FRAME_S,
        "the robot reports an emergency stop: the emergency stop on the robot was pressed",
    ),
    (press_pause, State.HOLDING, FRAME_S, "paused by the operator"),
    (press_stop, State.STOPPED, FRAME_S, "the operator pressed STOP"),
]


SHOWN = (hide_marker, silence_camera, freeze_camera, unplug_camera, carry_outside)
SHOWN += (carry_into_an_obstacle, carry_near_an_obstacle, carry_off_the_path)
"""What the pictures say, or their absence."""


@pytest.mark.parametrize(
    ("arena", "break_it", "state", "known_s", "words"),
    [(drawn, *row) for row in TABLE for drawn in ([True, False] if row[0] in SHOWN else [False])],
    indirect=["arena"],
    ids=lambda one: getattr(one, "__name__", None),
)
def test_each_broken_rule_stops_the_robot_within_one_cycle_and_says_why(
    arena: Arena, break_it: Callable[[Arena], None], state: State, known_s: float, words: str
) -> None:
    broken_s = arena.world.clock()
    break_it(arena)
    now = cycle_until(arena.daemon, lambda now: now.mission.state is not State.DRIVING)
    assert now.mission.state is state
    assert words in now.sentence
    assert arena.world.clock() - broken_s <= known_s + CYCLE_S
    if break_it is carry_off_the_path:
        return  # the cause has passed with the old plan: the robot goes on before it stands
    cycle_until(arena.daemon, lambda _: arena.stands(), LEASE_S + 0.1 + BRAKING_S)
    stood = arena.world.body.pose()
    later = cycle_until(arena.daemon, lambda _: arena.world.clock() > broken_s + 3.0)
    assert later.mission.state is state
    assert math.dist(stood[:2], arena.world.body.pose()[:2]) < 0.002


HEAL = {
    hide_marker: {"marker_hidden": False},
    silence_camera: {"camera_silent": False},
    freeze_camera: {"camera_frozen": False},
    unplug_camera: {"camera_lost": False},
    cut_cable: {"cable_out": False},
    break_port: {"port_broken": False},
    carry_off_the_path: {},
}


@pytest.mark.parametrize("break_it", HEAL, ids=[f.__name__ for f in HEAL])
def test_what_passes_by_itself_lets_the_mission_go_on(
    arena: Arena, break_it: Callable[[Arena], None]
) -> None:
    break_it(arena)
    arena.until(State.HOLDING)
    cycle_until(arena.daemon, lambda _: arena.stands())
    for name, value in HEAL[break_it].items():
        set_trouble(arena.world, name, value)
    ended = cycle_until(arena.daemon, lambda now: now.mission.is_over)
    assert ended.mission.state is State.DONE, ended.sentence
    assert math.dist(arena.world.body.pose()[:2], (0.20, 1.60)) < 0.01


@pytest.mark.parametrize(
    "news",
    [
        RobotRebooted(3, ResetCause.POWER_ON),
        LinkChanged(LinkState.STREAM, LinkState.CLOSED, "the port broke"),
    ],
    ids=["rebooted", "port closed"],
)
def test_a_robot_that_may_be_another_proves_itself_first(
    arena: Arena, news: RobotRebooted | LinkChanged
) -> None:
    break_port(arena)
    arena.until(State.HOLDING)
    arena.world.body.loop.events.append(news)
    arena.world.body.troubles.port_broken = False
    states: list[State] = []
    cycle_until(
        arena.daemon,
        lambda now: now.mission.state is State.DRIVING,
        each=lambda now: states.append(now.mission.state),
    )
    assert State.PROVING in states


@pytest.mark.parametrize("break_it", [press_the_button, press_stop])
def test_a_stop_is_latched_until_re_armed_and_resumed(
    arena: Arena, break_it: Callable[[Arena], None]
) -> None:
    break_it(arena)
    arena.until(State.STOPPED)
    cycle_until(arena.daemon, lambda _: arena.stands())
    since_s = arena.world.clock()
    cycle_until(arena.daemon, lambda _: arena.world.clock() > since_s + 3.0)
    assert arena.stands()
    arena.daemon.people.resume()
    cycle_until(arena.daemon, lambda _: arena.world.clock() > since_s + 6.0)
    assert arena.stands(), "re-armed is not going"
    arena.daemon.people.resume()
    ended = cycle_until(arena.daemon, lambda now: now.mission.is_over)
    assert ended.mission.state is State.DONE, ended.sentence


def test_a_stop_on_the_robot_is_said_without_a_mission_too_until_it_is_re_armed(
    arena: Arena,
) -> None:
    words = "the emergency stop on the robot was pressed; re-arm it"
    cycle_until(arena.daemon, lambda now: now.mission.is_over)
    press_the_button(arena)
    now = cycle_until(arena.daemon, lambda now: any(words in one for one in now.troubles), 1.0)
    assert now.mission.state is State.DONE
    arena.daemon.people.resume()
    said = []
    since_s = arena.world.clock()
    cycle_until(
        arena.daemon,
        lambda _: arena.world.clock() > since_s + 2.0,
        each=lambda now: said.extend(now.troubles),
    )
    assert said == []


def test_a_robot_whose_processor_hangs_is_said_and_goes_on_when_it_is_back(arena: Arena) -> None:
    since_s = arena.world.clock() - arena.world.truths[""].began_s
    arena.world.body.processor.faults = FaultSpec(freeze_at_s=since_s, freeze_s=1.0)
    now = arena.until(State.HOLDING)
    assert "did not report" in now.sentence or "link to the robot is down" in now.sentence
    assert cycle_until(arena.daemon, lambda now: now.mission.is_over).mission.state is State.DONE


def test_a_control_loop_that_hangs_stops_the_robot_by_its_lease(arena: Arena) -> None:
    arena.world.wait(LEASE_S + BRAKING_S + DRIVE_LAG_S)
    before = arena.world.body.pose()
    arena.world.wait(0.01)
    assert math.dist(before[:2], arena.world.body.pose()[:2]) <= 0.01 * 0.01, "creeps at most"
    arena.world.wait(2 * DRIVE_LAG_S)
    assert arena.stands()
    assert cycle_until(arena.daemon, lambda now: now.mission.is_over).mission.state is State.DONE


def test_a_planner_that_fails_holds_the_robot_and_is_started_again(
    arena: Arena, monkeypatch: pytest.MonkeyPatch
) -> None:
    answers: list[Exception] = [ZeroDivisionError("division by zero")] * 2
    plan = arena.daemon.traffic.planner.answer

    def fragile(request):  # type: ignore[no-untyped-def]
        if answers:
            raise answers.pop()
        return plan(request)

    monkeypatch.setattr(arena.daemon.traffic.planner, "answer", fragile)
    arena.daemon.people.replan()
    now = arena.until(State.HOLDING)
    assert now.sentence == (
        "the planner failed (ZeroDivisionError: division by zero): starting it again"
    )
    assert cycle_until(arena.daemon, lambda now: now.mission.is_over).mission.state is State.DONE
    assert arena.daemon._supervisor.restarts == 2


@drawn
def test_vision_that_fails_holds_the_robot_and_is_made_anew(
    arena: Arena, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_given: object) -> None:
        raise RuntimeError("no such picture")

    eye = arena.daemon.view.vision.eye
    monkeypatch.setattr(eye, "look", fail)
    now = arena.until(State.HOLDING)
    assert "the vision failed (RuntimeError: no such picture)" in now.sentence
    assert cycle_until(arena.daemon, lambda now: now.mission.is_over).mission.state is State.DONE
    assert arena.daemon.view.vision.eye is not eye


def test_a_camera_that_stays_away_is_tried_with_growing_pauses(arena: Arena) -> None:
    arena.world.cameras[None].camera_lost = True
    since_s = arena.world.clock()
    cycle_until(arena.daemon, lambda _: arena.world.clock() > since_s + 25.0, 30.0)
    reopened = arena.daemon.camera.status().reopened
    assert 5 <= reopened <= 9
    assert "unplugged" in arena.daemon.camera.status().reason


@drawn
def test_no_scene_ever_holds_the_robot_while_things_break(arena: Arena) -> None:
    scenes: list[Scene] = []

    def keep(_now: RobotSnapshot) -> None:
        if arena.daemon.scene is not None and arena.daemon.scene not in scenes[-1:]:
            scenes.append(arena.daemon.scene)

    hide_marker(arena)
    since_s = arena.world.clock()
    cycle_until(arena.daemon, lambda _: arena.world.clock() > since_s + 1.0, each=keep)
    arena.world.body.troubles.marker_hidden = False
    cycle_until(arena.daemon, lambda now: now.mission.is_over, each=keep)
    assert {len(scene.objects) for scene in scenes} == {7}
    assert np.isfinite(arena.world.truths[""].track()).all()


def test_the_end_of_a_run_waits_for_the_robots_rest(arena: Arena) -> None:
    assert arena.daemon.let_the_robots_stop() == []
    assert arena.stands()


def test_a_run_that_ends_without_a_report_of_rest_says_so(arena: Arena) -> None:
    arena.world.body.troubles.cable_out = True
    doubts = arena.daemon.let_the_robots_stop()
    assert doubts == ["the robot is not known to be at rest; its lease is over"]
    assert arena.stands()
