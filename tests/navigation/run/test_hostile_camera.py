"""A camera that lies while the robot drives, in virtual time: it may get no farther than a hand.

Ground truth decides: how far the robot drives after the lie begins, that it touches nothing, and
that the sentence names what was seen. The same lies in drawn pictures have the same answers:
`tests/navigation/run/without_pictures/test_both_kinds.py`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np
import pytest

from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RobotSnapshot
from navigation.loop.stages import stations_of
from navigation.mission.late_pictures import WORTH_A_PLAN, speed_with
from navigation.mission.mission import State
from navigation.mission.trust import Level
from navigation.shared.track import driven_pieces
from planner.borders.polyline import arc_lengths
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import cycle_until, is_driving, short_config

pytestmark = pytest.mark.slow

GOAL = (0.20, 1.60)
FAR = [{"x_m": GOAL[0], "y_m": GOAL[1]}]
HIGH_CAMERA = {
    "position_m": (1.155, 0.975, 2.9), "focal_px": 617.5, "centre_offset_px": (2.6, -1.9)
}  # fmt: skip
RADIUS_M = 0.09
BEHIND = (0.8, 0.5)
"""An obstacle lies between the way to the goal and here."""


@dataclass(slots=True)
class Stage:
    """A daemon, its world, and how far the robot has driven since `lie`."""

    world: TroubledWorld
    daemon: Daemon
    driven_m: float = 0.0
    said: list[str] = field(default_factory=list)
    _last: tuple[float, float] | None = None

    def watch(self, now: RobotSnapshot) -> None:
        here = self.world.body.pose()[:2]
        self.driven_m += math.dist(here, self._last or here)
        self._last = here
        if now.sentence not in self.said[-1:]:
            self.said.append(now.sentence)

    def set_off(self, cycles: int = 20) -> None:
        """Until the robot drives at full speed."""
        self.daemon.people.give(stations_of(self.daemon.config))
        cycle_until(self.daemon, is_driving)
        for _ in range(cycles):
            self.daemon.cycle()

    def until(self, *states: State, seconds: float = 45.0) -> RobotSnapshot:
        return cycle_until(
            self.daemon, lambda now: now.mission.state in states, seconds, self.watch
        )

    def rest(self, seconds: float = 2.0) -> None:
        """The robot comes to a stand; what it still drives counts."""
        until_s = self.world.clock() + seconds
        cycle_until(self.daemon, lambda _: self.world.clock() > until_s, seconds + 1.0, self.watch)

    def clearance_m(self) -> float:
        """The least true clearance of the whole track, above the radius."""
        truth = self.world.truths[""]
        return truth.track_clearance(truth.track()) - RADIUS_M


def stage_of(*, pictures: bool, rate_hz: float = 15.0) -> Iterator[Stage]:
    """A robot at its start."""
    config = short_config(FAR, simulation={"camera": HIGH_CAMERA}, camera={"rate_hz": rate_hz})
    world = TroubledWorld(config, pictures=pictures)
    with Daemon(config, world, first_mission_id=7) as daemon:
        yield Stage(world, daemon)


@pytest.fixture
def stage(request: pytest.FixtureRequest) -> Iterator[Stage]:
    """With drawn pictures where the parameter is ``True``."""
    yield from stage_of(pictures=getattr(request, "param", False))


@pytest.fixture
def rated_stage(request: pytest.FixtureRequest) -> Iterator[Stage]:
    """With as many pictures a second as the parameter has."""
    yield from stage_of(pictures=False, rate_hz=request.param)


def freeze_with_a_clock(stage: Stage) -> None:
    stage.world.cameras[None].camera_frozen = stage.world.cameras[None].clock_in_the_corner = True


def freeze_with_noise(stage: Stage) -> None:
    stage.world.cameras[None].camera_frozen = stage.world.cameras[None].frozen_noise = True


def play_a_loop(stage: Stage) -> None:
    stage.world.cameras[None].looping = True


def show_another_robot(stage: Stage) -> None:
    stage.world.body.troubles.marker_at = (1.2, 0.5, 0.3)


def lay_a_second_marker(stage: Stage) -> None:
    stage.world.body.troubles.double_at = (1.2, 0.5, 0.3)


def turn_the_marker(stage: Stage) -> None:
    stage.world.body.troubles.marker_turned = True


def shift_the_marker(stage: Stage) -> None:
    stage.world.body.troubles.marker_shift_m = (0.5, 0.0)


def hold_the_robot(stage: Stage) -> None:
    stage.world.body.troubles.stuck = True


LIES: list[tuple[Callable[[Stage], None], float, str]] = [
    # braking from 0.3 m/s alone takes 0.09 m
    (freeze_with_a_clock, 0.17, "from where its wheels brought it"),
    (freeze_with_noise, 0.17, "from where its wheels brought it"),
    (play_a_loop, 0.17, "from where its wheels brought it"),
    (show_another_robot, 0.17, "from where its wheels brought it"),
    (lay_a_second_marker, 0.17, "the robot's marker 7 is seen at"),
    (turn_the_marker, 0.17, "deg from where its wheels brought it"),
    (shift_the_marker, 0.17, "must be at least"),
    (hold_the_robot, 0.0, "from where its wheels brought it"),
]


@pytest.mark.parametrize(("lie", "most_m", "words"), LIES, ids=[row[0].__name__ for row in LIES])
def test_a_lie_of_the_camera_is_a_stop_within_a_hand(
    stage: Stage, lie: Callable[[Stage], None], most_m: float, words: str
) -> None:
    stage.set_off()
    assert stage.daemon.state is not None
    stage.watch(stage.daemon.state.only)
    lie(stage)
    ended = stage.until(State.STOPPED)
    stage.rest()
    assert words in ended.sentence, stage.said
    assert stage.driven_m <= most_m + 0.01
    assert stage.clearance_m() > 0.0


def test_a_marker_that_drifts_is_found_before_it_leads_the_robot_into_anything(
    stage: Stage,
) -> None:
    """Three centimetres a second, to 0.3 m."""
    stage.set_off()
    since_s = stage.world.clock()

    def drift(now: RobotSnapshot) -> None:
        shift_m = min(0.3, 0.03 * (stage.world.clock() - since_s))
        stage.world.body.troubles.marker_shift_m = (shift_m, 0.0)
        stage.watch(now)

    ended = cycle_until(stage.daemon, lambda now: now.mission.state is State.STOPPED, 30.0, drift)
    assert "camera" in ended.sentence
    assert any("in another direction than its wheels" in said for said in stage.said)
    assert stage.clearance_m() > 0.0


def test_a_robot_that_was_knocked_proves_itself_and_goes_on(stage: Stage) -> None:
    stage.set_off()
    x, y, heading = stage.world.body.pose()
    stage.world.body.troubles.carried_to = (x + 0.06, y, heading)
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence
    assert any(said.endswith("the robot turns a little to prove itself") for said in stage.said)
    assert math.dist(stage.world.body.pose()[:2], GOAL) < 0.01


def test_a_robot_that_was_carried_needs_a_person_who_looks(stage: Stage) -> None:
    stage.set_off()
    stage.world.body.troubles.carried_to = (0.2, 0.75, 1.0)
    ended = stage.until(State.STOPPED)
    assert "it was carried or is stuck" in ended.sentence
    stage.rest()
    stage.daemon.people.resume()
    stage.rest(1.0)
    stage.daemon.people.resume()
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence


def test_what_a_robot_was_carried_over_does_not_count_as_driven(stage: Stage) -> None:
    """Over an obstacle, in steps that the camera sees, and set down behind it."""
    stage.set_off()
    x, y, _ = stage.world.body.pose()
    for share in np.linspace(0.0, 1.0, 60):
        place = (x + share * (BEHIND[0] - x), y + share * (BEHIND[1] - y), 1.0)
        stage.world.body.troubles.carried_to = place
        stage.daemon.cycle()
    stage.until(State.STOPPED)
    for _ in range(2):
        stage.rest(1.0)
        stage.daemon.people.resume()
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence
    assert stage.world.truths[""].arena.track_clearance([(x, y), BEHIND])[0] < 0.0
    rows = stage.daemon.robot.sightings.rows()
    pieces = driven_pieces(rows, 0.3)
    assert len(pieces) == 2
    for piece in pieces:
        assert stage.world.truths[""].arena.track_clearance(piece[:, 1:3])[0] > RADIUS_M
    length_m = sum(arc_lengths(piece[:, 1:3])[-1] for piece in pieces)
    assert arc_lengths(rows[:, 1:3])[-1] - length_m > 0.8 * math.dist((x, y), BEHIND)


def test_a_robot_that_was_hidden_proves_itself_slowly_before_it_drives_on(stage: Stage) -> None:
    stage.set_off()
    stage.world.body.troubles.marker_hidden = True
    stage.until(State.HOLDING)
    stage.rest()
    stage.world.body.troubles.marker_hidden = False
    stage.until(State.PROVING)
    stood = stage.world.body.pose()[:2]
    stage.until(State.DRIVING)
    assert math.dist(stood, stage.world.body.pose()[:2]) < 0.01, "it turned on the spot"
    assert stage.daemon.robot.pilot.trust.level is Level.PROBATION
    assert stage.daemon.robot.pilot.plan.targets[0].speed_m_s <= 0.08
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence


@pytest.mark.parametrize(
    ("stage", "latency_s"),
    [(True, 0.1), (False, 0.05), (False, 0.1), (False, 0.2)],
    ids=["drawn-0.1", "without_pictures-0.05", "without_pictures-0.1", "without_pictures-0.2"],
    indirect=["stage"],
)
def test_a_late_stream_is_measured_and_driven_with(stage: Stage, latency_s: float) -> None:
    stage.world.cameras[None].stream_latency_s = latency_s
    stage.daemon.people.give(stations_of(stage.daemon.config))
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence
    found_s = stage.daemon.robot.witness.evidence().latency_s
    assert found_s == pytest.approx(latency_s, abs=0.03)
    assert stage.clearance_m() > 0.02
    assert math.dist(stage.world.body.pose()[:2], GOAL) < 0.01


@pytest.mark.parametrize(
    ("stage", "latency_s"),
    [(True, 0.6), (False, 0.35), (False, 0.6), (False, 0.9)],
    ids=["drawn-0.6", "without_pictures-0.35", "without_pictures-0.6", "without_pictures-0.9"],
    indirect=["stage"],
)
def test_a_stream_that_is_too_late_is_not_driven_with(stage: Stage, latency_s: float) -> None:
    stage.world.cameras[None].stream_latency_s = latency_s
    stage.daemon.people.give(stations_of(stage.daemon.config))
    ended = stage.until(State.FAILED, State.STOPPED, seconds=90.0)
    stage.rest()
    late = f"the camera's pictures are {latency_s:.1f}"
    assert any(late[:-1] in said for said in stage.said), stage.said
    assert "limit is 0.25 s" in ended.sentence or ended.mission.state is State.FAILED
    assert stage.driven_m < 0.1
    assert stage.clearance_m() > 0.05


@pytest.mark.parametrize("rated_stage", [30.0], indirect=True)
def test_a_stream_that_becomes_late_is_held_for_and_driven_with_more_slowly(
    rated_stage: Stage,
) -> None:
    rated_stage.set_off(14)
    rated_stage.world.cameras[None].stream_latency_s = 0.22
    ended = rated_stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence
    assert rated_stage.daemon.robot.pilot.plan.speed_m_s < 0.27
    assert rated_stage.clearance_m() > 0.02


@pytest.mark.parametrize("rated_stage", [10.0, 15.0, 30.0], indirect=True)
def test_a_latency_that_is_measured_just_as_its_guess_parts_stops_nobody(
    rated_stage: Stage,
) -> None:
    """Measured while the robot drives: its plan stays if it is hardly faster than is allowed."""
    rated_stage.set_off(20)
    rated_stage.world.cameras[None].stream_latency_s = 0.22
    ended = rated_stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence
    pilot, evidence = rated_stage.daemon.robot.pilot, rated_stage.daemon.robot.witness.evidence()
    robot = pilot.settings.traffic
    allowed_m_s = speed_with(evidence.longest_latency_s, robot.speed_m_s, robot.acceleration_m_s2)
    assert WORTH_A_PLAN * pilot.plan.speed_m_s <= allowed_m_s
    assert rated_stage.clearance_m() > 0.02


def test_a_stamp_in_the_future_counts_as_now(stage: Stage) -> None:
    stage.world.cameras[None].future_s = 3600.0
    stage.daemon.people.give(stations_of(stage.daemon.config))
    ended = stage.until(State.DONE, State.FAILED, State.STOPPED)
    assert ended.mission.state is State.DONE, ended.sentence


def test_pushed_back_time_and_again_the_mission_is_given_up() -> None:
    """States alone would never count: every push is a hold, a proof, a plan and a drive."""
    config = short_config(
        FAR,
        simulation={"camera": HIGH_CAMERA},
        robot={"speed_m_s": 0.1},
        planning={"slow_speed_m_s": 0.1},
        safety={"give_up_s": 5.0},
    )
    world = TroubledWorld(config, pictures=False)
    with Daemon(config, world, first_mission_id=7) as daemon:
        daemon.people.give(stations_of(config))
        cycle_until(daemon, is_driving)
        x0, y0, _ = world.body.pose()
        pushes = 0

        def push(now: RobotSnapshot) -> None:
            nonlocal pushes
            x, y, heading = world.body.pose()
            if now.mission.state is State.DRIVING and math.dist((x, y), (x0, y0)) > 0.05:
                pushes += 1
                world.body.troubles.carried_to = (x0, y0, heading)
                daemon.robot.pilot.trust.vouch()  # who pushes it also says that all is well

        ended = cycle_until(daemon, lambda now: now.mission.is_over, 100.0, push)
    assert ended.mission.state is State.FAILED
    assert "given up after 5 s without progress" in ended.sentence
    assert pushes > 1
