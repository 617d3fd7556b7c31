"""A camera that is pulled out and comes back, under another name, with its controls restored."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.processes.v4l2_preloaded import NEEDS_GCC, video_nodes
from tests.support.processes.v4l2_replug import replug

pytestmark = NEEDS_GCC


def test_a_camera_is_back_within_two_seconds_of_its_plug_and_set_again(tmp_path: Path) -> None:
    """However long it was away: a camera that is not there is looked for twice a second."""
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node], away_s=4.0)
    assert told["lost_s"] < 2.0
    assert told["back_s"] < 2.0
    assert told["values"]["Exposure Time, Absolute"] == 70
    assert told["values"]["Auto Exposure"] == 1
    assert any("unplugged" in reason for reason in told["reasons"])


def test_a_camera_is_found_under_another_name(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [tmp_path / "video4"])
    assert told["back_s"] < 2.0
    assert told["reasons"][-1] == f"found again as {tmp_path / 'video4'}"


def test_another_camera_that_has_taken_its_name_is_refused(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node], change='{"V4L2_CARD": "Another"}')
    assert told["back_s"] is None
    assert f"{node} is another camera (Another) than before (Fake camera)" in told["reasons"][-1]


def test_of_two_cameras_that_are_alike_none_is_guessed(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [tmp_path / "video4", tmp_path / "video5"])
    assert told["back_s"] is None
    assert "are alike, and neither is where the camera was" in told["reasons"][-1]


@pytest.mark.parametrize("others", [0, 1])
def test_of_two_cameras_that_are_alike_the_one_at_the_same_port_is_taken(
    tmp_path: Path, others: int
) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    told = replug(node, [node, *[tmp_path / f"video{4 + n}" for n in range(others)]])
    assert told["back_s"] < 2.0
    assert not any("found again" in reason for reason in told["reasons"])
