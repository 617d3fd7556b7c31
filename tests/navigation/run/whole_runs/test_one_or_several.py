"""What one robot has, several have: each test is run with one robot and with two.

Where several lack it, their case is expected to fail, and the reason says what is missing. All runs
are whole runs of the program in virtual time, without pictures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import pytest

from navigation.config import Config, ConfigError, parse_config
from navigation.config.sections import RobotEntry, RobotSection
from navigation.run import runner
from navigation.simulator.virtual_loop import VirtualLoop
from tests.navigation.config.test_several_robots import FLEET
from tests.support.runs.boundaries import camera_lost, one_robot, several_robots
from tests.support.runs.troubled_robot import RobotTroubles
from tests.support.runs.troubled_world import TroubledWorld
from tests.support.runs.virtual import short_config
from tests.support.runs.whole_run import WholeRun, run_whole

pytestmark = pytest.mark.slow

Make = Callable[[], Config]
Run = Callable[..., WholeRun]


def several_lack(reason: str) -> pytest.MarkDecorator:
    """One robot has it; several are expected to fail for this reason."""
    lack = pytest.mark.xfail(strict=True, raises=AssertionError, reason=reason)
    several = pytest.param(several_robots, id="several", marks=lack)
    return pytest.mark.parametrize("make", [pytest.param(one_robot, id="one"), several])


BOTH = pytest.mark.parametrize("make", [one_robot, several_robots], ids=["one", "several"])


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs a configuration to its end; arguments as `run_whole`'s."""

    def whole(config: Config, at: Mapping[float, Any] | None = None, **how: bool) -> WholeRun:
        return run_whole(config, tmp_path, monkeypatch, at, **how)

    return whole


@pytest.fixture(scope="module")
def troubled(tmp_path_factory: pytest.TempPathFactory) -> Callable[[Make], WholeRun]:
    """A run whose first robot's cable is out for a second, and then the camera; made once."""
    made: dict[Make, WholeRun] = {}

    def of(make: Make) -> WholeRun:
        if make not in made:
            at = {
                1.5: cable_out(True),
                2.5: cable_out(False),
                3.5: camera_lost(True),
                4.5: camera_lost(False),
            }
            with pytest.MonkeyPatch.context() as patch:
                made[make] = run_whole(make(), tmp_path_factory.mktemp("run"), patch, at)
        return made[make]

    return of


def first_robot(world: TroubledWorld) -> tuple[VirtualLoop, RobotTroubles]:
    """The line of the first robot, and its troubles."""
    body = next(iter(world.bodies.values()))
    return body.loop, body.troubles


def cable_out(out: bool) -> Callable[[TroubledWorld], None]:
    def happen(world: TroubledWorld) -> None:
        first_robot(world)[1].cable_out = out

    return happen


def with_simulated(config: Config, **robot: Any) -> Config:
    """The configuration with other values of simulation.robot."""
    values = config.model_dump()
    values["simulation"]["robot"].update(robot)
    return Config.model_validate(values)


# The log of events, and what the terminal and systemd are told.


@BOTH
def test_a_lost_camera_is_a_warning_in_the_log(troubled: Any, make: Make) -> None:
    levels = {one["state"]: one["level"] for one in troubled(make).events_called("camera")}
    assert levels.items() >= {"lost": "warning", "running": "info"}.items()


@BOTH
def test_a_link_that_is_down_is_a_warning_in_the_log(troubled: Any, make: Make) -> None:
    levels = {one["state"]: one["level"] for one in troubled(make).events_called("link")}
    assert levels.items() >= {"down": "warning", "up": "info"}.items()


@BOTH
def test_each_new_plan_is_in_the_log_with_its_length_and_clearance(
    troubled: Any, make: Make
) -> None:
    plans = troubled(make).events_called("plan")
    assert len(plans) >= 2
    assert all(one["length_m"] > 0.0 < one["min_clearance_m"] for one in plans)


@BOTH
def test_each_visited_station_is_in_the_log(troubled: Any, make: Make) -> None:
    assert len(troubled(make).events_called("station")) == 2


@BOTH
def test_each_state_is_in_the_log_with_the_robot_s_place(troubled: Any, make: Make) -> None:
    states = troubled(make).events_called("state")
    assert all({"x_m", "y_m", "heading_rad", "clearance_m"} <= one.keys() for one in states)


@BOTH
def test_a_stop_is_a_warning_in_the_log(run: Run, make: Make) -> None:
    ran = run(make(), {2.0: {"order": "stop"}, 5.0: {"order": "resume"}, 5.5: {"order": "resume"}})
    levels = {one["state"]: one["level"] for one in ran.events_called("state")}
    assert levels["stopped"] == "warning"


@BOTH
def test_a_stage_that_hangs_is_an_error_in_the_log(
    run: Run, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    hangs = MagicMock(hanging=("planner",))
    monkeypatch.setattr(runner, "Watchdog", lambda *_: hangs)
    logged = run(make()).events_called("watchdog")
    assert [(one["level"], one["stages"]) for one in logged] == [("error", "planner")]


@BOTH
def test_a_recording_that_has_ended_is_said_and_an_error_in_the_log(
    run: Run, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    dead = MagicMock(path=Path("recording"))
    dead.__enter__.return_value = dead
    dead.has_ended.return_value = True
    dead.counts.return_value = MagicMock(dropped=0, failed="the disk is gone", waiting=0)
    monkeypatch.setattr("navigation.loop.recorder.Recorder", lambda *_, **__: dead)
    values = make().model_dump()
    values["recording"]["record"] = True
    ran = run(Config.model_validate(values))
    assert [one["level"] for one in ran.events_called("recording")] == ["error"]
    assert "recording: ended early: the disk is gone" in ran.said


@BOTH
def test_a_camera_that_is_waited_for_is_said(troubled: Any, make: Make) -> None:
    said = troubled(make).said
    assert any(one.startswith("waiting for the camera: ") for one in said)
    assert "the camera gives pictures" in said


@BOTH
def test_systemd_is_told_what_the_run_does(troubled: Any, make: Make) -> None:
    told = [one for one in troubled(make).notified if one.startswith("STATUS=")]
    assert any("driving" in one for one in told)
    assert any("no picture from the camera" in one for one in told)


# What a run leaves behind, and how it ends.


@BOTH
@pytest.mark.parametrize("layer", ["roadmap", "path"])
def test_the_picture_shows_the_roadmap_and_what_was_planned(
    troubled: Any, make: Make, layer: str
) -> None:
    drawn = (troubled(make).folder / "track.svg").read_text(encoding="utf-8")
    assert f'<g id="{layer}"' in drawn


def nothing_to_do(make: Make) -> Config:
    values = make().model_dump()
    values["mission"].update(stations=[], robots=[])
    return Config.model_validate(values)


@BOTH
def test_an_interrupt_before_the_beginning_of_a_run_without_missions_is_no_failure(
    run: Run, make: Make
) -> None:
    assert run(nothing_to_do(make), interrupted=True).exit_code == runner.DONE


@BOTH
def test_an_interrupt_before_the_beginning_of_a_mission_is_a_failure(run: Run, make: Make) -> None:
    ran = run(make(), interrupted=True)
    assert ran.exit_code == runner.FAILED
    assert [one["state"] for one in ran.events_called("finished")] == ["stopped"]
    each = ran.report.get("robots", {"": ran.report})
    assert list(each) == ([one.name for one in make().robots] or [""])
    assert {one["state"] for one in each.values()} == {"stopped"}


# Simulated faults.


@BOTH
def test_a_simulated_processor_restarts_when_its_faults_say_so(run: Run, make: Make) -> None:
    boots: list[int] = []

    def note(world: TroubledWorld) -> None:
        boots.append(first_robot(world)[0].robot.identity.boot_id)

    run(with_simulated(make(), faults="reset=2"), {1.5: note, 2.5: note})
    assert boots[0] != boots[1]


@BOTH
def test_a_simulated_processor_hangs_when_its_faults_say_so(run: Run, make: Make) -> None:
    frozen: list[bool] = []

    def note(world: TroubledWorld) -> None:
        frozen.append(first_robot(world)[0].knobs.frozen)

    run(with_simulated(make(), faults="freeze=0.5@2"), {1.9: note, 2.3: note, 2.7: note})
    assert frozen == [False, True, False]


# The page.


@BOTH
def test_the_page_can_calibrate_the_camera(
    run: Run, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = MagicMock()
    monkeypatch.setattr("navigation.dashboard.Dashboard", page)
    run(make(), dashboard=True)
    assert page.call_args.kwargs["bench"] is not None


# In which order stations are visited.


@BOTH
def test_the_best_order_of_stations_is_driven(run: Run, make: Make) -> None:
    """As written the first robot would drive past its second station, and back."""
    values = make().model_dump()
    mission = values["mission"]
    mission["order"] = "best"
    stations = [{"x_m": 0.20, "y_m": y_m} for y_m in (0.70, 0.45, 0.95)]
    for one in (mission, *mission["robots"][:1]):
        if one["stations"]:
            one["stations"] = stations
    heights_m: list[float] = []

    def note(world: TroubledWorld) -> None:
        heights_m.append(first_robot(world)[0].drive.pose[1])

    ran = run(Config.model_validate(values), {0.1 * k: note for k in range(1, 200)})
    assert ran.exit_code == runner.DONE
    assert max(heights_m) > 0.9
    assert all(b - a > -0.05 for a, b in pairwise(heights_m)), "it never turns back"


# Configurations of one robot and of several.


def test_each_of_several_robots_takes_every_key_of_a_robot_alone() -> None:
    assert RobotSection.model_fields.keys() <= RobotEntry.model_fields.keys()


@pytest.mark.parametrize(
    ("before", "after"),
    [
        pytest.param("speed_m_s: 0.2}", "speed_m_s: 0.125, driver: epuck2}", id="a driver"),
        pytest.param(
            "speed_m_s: 0.3\n",
            "speed_m_s: 0.3\n  turns_on_spot: false\n  turning_radius_m: 0.15\n",
            id="no turns on the spot",
        ),
        pytest.param("mission:\n", "mission:\n  order: best\n", id="order: best"),
    ],
)
def test_what_one_robot_may_be_configured_to_do_several_may(before: str, after: str) -> None:
    assert before in FLEET
    refused = ""
    try:
        parse_config(FLEET.replace(before, after, 1))
    except ConfigError as error:
        refused = str(error)
    assert refused == ""


# One camera of several.


@pytest.mark.xfail(
    strict=True,
    raises=AssertionError,
    reason="all robots hold where one of several cameras is lost, wherever they are",
)
def test_a_robot_that_another_camera_sees_drives_on_where_one_camera_is_lost(run: Run) -> None:
    def right_lost(lost: bool) -> Callable[[TroubledWorld], None]:
        def happen(world: TroubledWorld) -> None:
            world.cameras["right"].camera_lost = lost  # type: ignore[index]

        return happen

    ran = run(under_two_cameras(), {2.0: right_lost(True), 5.0: right_lost(False)})
    held = {
        one["robot"]
        for one in ran.events_called("state")
        if one["state"] == "holding" and "camera" in one["reason"]
    }
    assert held == {"b"}, "a begins and ends under the left camera"


def under_two_cameras() -> Config:
    """Robot a goes from place to place under the left camera, b under the right one."""
    values = several_robots().model_dump()
    values["cameras"] = [{"name": "left"}, {"name": "right"}]
    places = {"left": (0.62, 0.93, 2.5), "right": (1.80, 0.88, 2.5)}
    values["simulation"]["cameras"] = [
        {"name": name, "position_m": place} for name, place in places.items()
    ]
    return Config.model_validate(values)


def test_two_robots_alike_are_what_these_tests_compare() -> None:
    """One robot's configuration is several robots', but for the second robot."""
    one, several = one_robot(), several_robots()
    assert one.robot.model_copy(update={"marker_id": 0}) == several.robot
    assert one.camera == several.camera == short_config([]).camera
