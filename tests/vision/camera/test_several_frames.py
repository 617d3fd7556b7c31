"""Several cameras read as one: whoever has news is heard, and who is lost keeps nobody waiting."""

from __future__ import annotations

import threading

from tests.vision.camera.scripted import Clock, Event, ScriptedCamera, picture
from vision.camera.camera import CameraError
from vision.camera.several_frames import SeveralFrames


def readers(**scripts: list[Event]) -> tuple[SeveralFrames, Clock]:
    clock = Clock()
    cameras = {name: ScriptedCamera(clock, iter(one)) for name, one in scripts.items()}
    return SeveralFrames({n: lambda c=c: c for n, c in cameras.items()}, clock), clock


def test_frames_come_by_turns_with_the_names_of_their_cameras() -> None:
    both, _ = readers(left=[picture(i) for i in range(9)], right=[picture(i) for i in range(9)])
    seen = []
    for _ in range(4):
        both.step()
        for _ in range(3):
            frame = both.take()
            if frame is not None:
                seen.append(frame.source)
    assert seen[:4] == ["left", "right"] * 2 or seen[:4] == ["right", "left"] * 2


def test_one_that_is_lost_is_said_and_the_other_runs() -> None:
    gone = CameraError("camera T: is unplugged")
    both, _ = readers(left=[picture(i) for i in range(40)], right=[picture(0), *[gone] * 40])
    for _ in range(20):
        both.step()
        both.take()
    status = both.status()
    each = dict(status.each)
    assert status.state == "running"
    assert each["left"].state == "running"
    assert each["right"].state != "running"
    assert "right: camera T" in status.reason
    assert status.captured == each["left"].captured + each["right"].captured


def test_whoever_waits_is_woken_by_either_camera_and_by_wake() -> None:
    both, _ = readers(left=[], right=[])
    woken = []
    waiter = threading.Thread(target=lambda: woken.append(both.take(20.0)))
    waiter.start()
    both.wake()
    waiter.join(10.0)
    assert woken == [None]
    both.start()
    both.stop()
    assert both.status().state == "closed"
    assert not both.has_died()
