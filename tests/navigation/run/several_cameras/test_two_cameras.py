"""A run with two cameras in virtual time: what one of them sees is closed while it is lost.

Ground truth decides: the robot never drives into what no camera sees, touches nothing, and drives
on when the camera is back. Three runs draw pictures too: the seam, a picture that is the same
again, and obstacles of a part are theirs to show; a camera that is gone shows none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from navigation.config import Config
from navigation.loop.daemon import Daemon
from navigation.loop.stages import stations_of
from navigation.mission.mission import State
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.two_cameras import RADIUS_M, Stage, config_of
from tests.support.runs.virtual import cycle_until

pytestmark = pytest.mark.slow

BRAKING_M = 0.3 * (0.2 + 0.5) + 0.3**2 / (2 * 0.5) + 0.02
"""Until it is noticed, until the permit ends, and the brakes."""


def stage_of(config: Config, *, pictures: bool) -> Iterator[Stage]:
    stage = Stage(config, pictures=pictures)
    with stage.daemon:
        yield stage


def drawn_too(stage: str) -> pytest.MarkDecorator:
    """A test that runs with pictures and without."""
    names = ["drawn", "without_pictures"]
    return pytest.mark.parametrize(stage, [True, False], ids=names, indirect=True)


@pytest.fixture
def across(request: pytest.FixtureRequest) -> Iterator[Stage]:
    """From what only the left camera sees to what only the right one sees."""
    config = config_of((2.2, 1.6), start=(0.72, 1.52))
    yield from stage_of(config, pictures=getattr(request, "param", False))


@pytest.fixture
def on_the_right(request: pytest.FixtureRequest) -> Iterator[Stage]:
    """Within what the right camera sees."""
    config = config_of((2.2, 1.6), (1.42, 0.95), start=(1.42, 0.95))
    yield from stage_of(config, pictures=getattr(request, "param", False))


@drawn_too("across")
def test_a_mission_across_the_seam_is_driven(across: Stage) -> None:
    across.set_off()
    assert across.until(State.DONE, State.FAILED, State.STOPPED).mission.state is State.DONE
    assert math.dist(across.where(), (2.2, 1.6)) < 0.01
    assert across.clearance_m() > 0.0
    assert not across.troubles


@pytest.mark.parametrize("how", ["camera_lost", "camera_frozen"])
def test_the_robot_does_not_enter_what_a_lost_camera_saw(across: Stage, how: str) -> None:
    across.set_off()
    setattr(across.world.cameras["right"], how, True)
    across.wait(6.0)
    plan = across.world.floor_plan
    assert plan is not None
    closed = plan.unknown((True, False))
    assert closed is not None
    assert not plan.is_unknown(closed, *across.where(), RADIUS_M)
    assert any("camera right is lost" in one for one in across.troubles)
    assert "camera left" not in " ".join(across.troubles)
    setattr(across.world.cameras["right"], how, False)
    now = across.until(State.DONE, State.FAILED, State.STOPPED, seconds=60.0)
    assert now.mission.state is State.DONE
    assert not now.troubles
    assert across.clearance_m() > 0.0


@pytest.mark.parametrize(
    ("across", "how"),
    [(True, "camera_frozen"), (False, "camera_frozen"), (False, "camera_silent")],
    ids=["drawn-camera_frozen", "without_pictures-camera_frozen", "without_pictures-camera_silent"],
    indirect=["across"],
)
def test_a_robot_in_what_a_lost_camera_saw_stops_and_drives_on_when_it_is_back(
    across: Stage, how: str
) -> None:
    across.set_off()
    cycle_until(across.daemon, lambda _: across.where()[0] > 0.8, each=across.watch)
    while across.where()[0] < 1.9:  # well inside what only the right camera sees
        across.watch(across.daemon.cycle().only)
    lost_at = across.where()
    setattr(across.world.cameras["right"], how, True)
    now = across.wait(3.0)
    assert now.mission.state is State.HOLDING
    assert math.dist(across.where(), lost_at) < BRAKING_M
    stood = across.where()
    across.wait(2.0)
    assert math.dist(across.where(), stood) < 0.002
    assert any("no camera sees the floor: right is lost" in one for one in across.said)
    setattr(across.world.cameras["right"], how, False)
    now = across.until(State.DONE, State.FAILED, State.STOPPED, seconds=60.0)
    assert now.mission.state is State.DONE
    assert across.clearance_m() > 0.0


def test_a_robot_outside_what_a_lost_camera_saw_drives_on(on_the_right: Stage) -> None:
    on_the_right.set_off()
    on_the_right.world.cameras["left"].camera_lost = True
    now = on_the_right.until(State.DONE, State.FAILED, State.STOPPED)
    assert now.mission.state is State.DONE
    assert any("camera left is lost" in one for one in now.troubles)
    assert on_the_right.clearance_m() > 0.0


@drawn_too("on_the_right")
def test_a_camera_that_is_missing_from_the_start_closes_its_part(on_the_right: Stage) -> None:
    on_the_right.world.cameras["left"].camera_lost = True
    on_the_right.set_off()
    now = on_the_right.until(State.DONE, State.FAILED, State.STOPPED)
    assert now.mission.state is State.DONE
    scene = on_the_right.daemon.scene
    assert scene is not None
    assert len(scene.objects) >= 2  # the fence, and what the right camera sees


def test_without_any_camera_the_robot_stands(across: Stage) -> None:
    across.set_off()
    across.wait(1.0)
    for name in ("left", "right"):
        across.world.cameras[name].camera_lost = True
    now = across.wait(3.0)
    assert now.mission.state is State.HOLDING
    assert "no picture from the camera" in now.sentence
    stood = across.where()
    across.wait(1.0)
    assert math.dist(across.where(), stood) < 0.002


def test_calibrations_of_two_floors_are_refused_with_the_number() -> None:
    """With pictures: that two cameras' outlines lie apart."""
    config = config_of((2.2, 1.6), start=(0.72, 1.52))
    world = TroubledWorld(config)
    plan = world.floor_plan
    assert plan is not None
    assert config.simulation is not None
    # who calibrated the right camera took a point 6 cm beside the floor's origin for it
    cameras = list(config.simulation.cameras)
    x, y, z = cameras[1].position_m or (0.0, 0.0, 0.0)
    cameras[1] = cameras[1].model_copy(update={"position_m": (x + 0.06, y + 0.06, z)})
    simulation = config.simulation.model_copy(update={"cameras": tuple(cameras)})
    wrong = TroubledWorld(config.model_copy(update={"simulation": simulation})).floor_plan
    world.floor_plan = wrong
    with Daemon(config, world, first_mission_id=1) as daemon:
        daemon.people.give(stations_of(config))
        now = cycle_until(daemon, lambda now: "see the same outlines" in now.sentence, seconds=10.0)
        assert "cameras left and right" in now.sentence
        assert "mm apart, the limit is 20" in now.sentence
        assert now.mission.state is not State.DRIVING
