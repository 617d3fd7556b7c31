from dataclasses import replace

import pytest

from firmware_protocol.host.upload import Upload
from firmware_protocol.wire.messages import (
    CommandResult,
    RobotState,
    Status,
    StatusFlag,
    StopReason,
    Waypoint,
)
from firmware_protocol.wire.mission import Mission

WAYPOINTS = [Waypoint(0.1 * i, 0.0, 0.3) for i in range(20)]
MISSION = Mission(7, WAYPOINTS)


def status(accepted: int, executed: int = 0, mission: Mission = MISSION) -> Status:
    """What a robot that has done everything right reports."""
    prefix, done = mission.prefix_crc(accepted), mission.prefix_crc(executed)
    assert prefix is not None
    assert done is not None
    return Status(
        time_us=0,
        boot_id=1,
        mission=mission.id,
        accept_next=accepted,
        exec_next=executed,
        prefix_crc=prefix,
        exec_crc=done,
        state=RobotState.RUN,
        flags=StatusFlag.NONE,
        reason=StopReason.NONE,
        result=CommandResult.NONE,
        command=0,
        x_m=0.0,
        y_m=0.0,
        heading_rad=0.0,
        speed_m_s=0.0,
        turn_rad_s=0.0,
        pose_age_s=0.0,
        lease_left_s=0.0,
    )


def send_all(upload: Upload) -> list[int]:
    """The first index of every batch that may be sent now."""
    firsts = []
    while (batch := upload.next_batch()) is not None:
        upload.sent(batch)
        firsts.append(batch.first)
    return firsts


def test_nothing_is_sent_before_the_robot_holds_the_mission() -> None:
    upload = Upload(MISSION)
    upload.see_ack(0, 32)
    assert upload.next_batch() is None
    assert upload.see_status(status(0), 32, True) is None
    assert send_all(upload) == [0, 5, 10, 15]


def test_credit_is_never_exceeded_and_frames_are_full() -> None:
    mission = Mission(7, WAYPOINTS[:17])
    upload = Upload(mission)
    upload.see_status(status(0, mission=mission), 13, True)
    assert send_all(upload) == [0, 5]
    upload.see_ack(10, 3)
    assert upload.next_batch() is None
    assert upload.blocked
    upload.see_ack(10, 5)
    assert send_all(upload) == [10]
    upload.see_ack(15, 2)
    assert send_all(upload) == [15], "the mission's end may be a short frame"


def test_waypoints_acknowledged_but_not_accepted_are_sent_again() -> None:
    """As after a frame whose sequence number belonged to another turn of the circle."""
    upload = Upload(MISSION)
    upload.see_status(status(0), 32, True)
    send_all(upload)
    assert upload.see_status(status(5), 27, all_acknowledged=False) is None
    assert upload.next_batch() is None, "they may still be on their way"
    upload.see_status(status(5), 27, all_acknowledged=True)
    assert send_all(upload) == [5, 10, 15]


def test_a_new_session_goes_on_where_the_robot_is() -> None:
    upload = Upload(MISSION)
    upload.see_status(status(0), 32, True)
    send_all(upload)
    upload.new_session()
    assert upload.next_batch() is None
    upload.see_status(status(12, 3), 23, True)
    assert send_all(upload) == [12, 17]


def test_an_old_missions_acknowledgement_is_not_believed() -> None:
    upload = Upload(MISSION)
    upload.see_status(status(0), 32, True)
    upload.see_ack(18, 32)
    assert upload.accepted == 0
    assert send_all(upload)[0] == 0


@pytest.mark.parametrize("field", ["prefix_crc", "exec_crc"])
def test_a_difference_in_either_chain_ends_the_mission(field: str) -> None:
    upload = Upload(MISSION)
    wrong = replace(status(6, 3), **{field: 1})
    assert "waypoints" in str(upload.see_status(wrong, 26, True))


def test_more_waypoints_than_the_mission_has_are_a_difference() -> None:
    upload = Upload(MISSION)
    assert upload.see_status(replace(status(20), accept_next=21), 0, True) is not None


def test_another_mission_on_the_robot_ends_ours_only_after_it_was_there() -> None:
    upload, other = Upload(MISSION), Mission(8, [Waypoint(0.0, 0.0, 0.1)])
    assert upload.see_status(status(0, mission=other), 32, True) is None
    upload.see_status(status(0), 32, True)
    assert "holds mission" in str(upload.see_status(status(0, mission=other), 32, True))


def test_done_needs_the_whole_chain_and_the_robots_word() -> None:
    upload = Upload(MISSION)
    upload.see_status(status(20, 20), 32, True)
    assert not upload.done
    assert upload.complete
    upload.see_status(replace(status(20, 20), flags=StatusFlag.MISSION_DONE), 32, True)
    assert upload.done
