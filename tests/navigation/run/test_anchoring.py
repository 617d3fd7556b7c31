"""The anchoring renewed: what is refused changes no file, and a run takes over what was written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navigation.config import Config, load_config
from navigation.control import ControlServer, send_order
from navigation.loop.people import People
from navigation.mission.mission import MissionError
from navigation.orders.carry_out import carry_out
from navigation.run.anchoring import (
    AnchoringError,
    renew,
    renew_while_running,
    take_over_lens,
)
from navigation.run.reload import Reloader
from tests.support.people import RecordedPeople
from vision.calibrate.lens import Lens
from vision.calibration.calibration_file import load_lens
from vision.camera.camera import Frame

EMPTY = np.full((960, 1280), 200, dtype=np.uint8)
NOW = datetime(2026, 1, 2)
MARKERS = [{"marker_id": 20 + i, "size_m": 0.1, "place_m": (0.1 * i, 0.0)} for i in range(4)]


def with_markers(config: Config, markers: Sequence[Mapping[str, Any]]) -> Config:
    values = config.model_dump()
    values["arena"]["floor_markers"] = markers
    return Config.model_validate(values)


def test_what_is_missing_is_said_and_nothing_is_written(config_file: Path) -> None:
    config = load_config(config_file, {})
    file = config.camera.calibration
    assert file is not None
    before = sorted(file.parent.iterdir())
    with pytest.raises(AnchoringError, match="none has a place_m"):
        renew(config, [EMPTY], NOW)
    with pytest.raises(AnchoringError, match=r"0 floor markers .* not seen: 20, 21, 22, 23"):
        renew(with_markers(config, MARKERS), [EMPTY], NOW)
    with pytest.raises(AnchoringError, match="640x480"):
        renew(with_markers(config, MARKERS), [EMPTY[:480, :640]], NOW)
    assert sorted(file.parent.iterdir()) == before
    camera = config.camera.model_copy(update={"calibration": None, "metres_per_pixel": 0.002})
    with pytest.raises(AnchoringError, match="names no file"):
        renew(config.model_copy(update={"camera": camera}), [EMPTY], NOW)


def test_a_run_refuses_as_it_refuses_any_order(config_file: Path) -> None:
    config = load_config(config_file, {})
    with pytest.raises(MissionError, match="no picture"):
        renew_while_running(config, None, lambda _camera: None, None)
    with pytest.raises(MissionError, match="place_m"):
        renew_while_running(config, None, lambda _camera: Frame(EMPTY, 0.0, 0, "test"), None)
    with pytest.raises(MissionError, match="camera 'left': there is one, which has no name"):
        renew_while_running(config, "left", lambda _camera: None, None)


def test_the_order_is_answered_with_what_was_found_or_why_not() -> None:
    people = RecordedPeople(reanchor=["anchored"])
    answer = carry_out({"order": "reanchor"}, people)
    assert (answer["ok"], answer["anchoring"], answer["state"]) == (True, ["anchored"], "idle")
    assert carry_out({"order": "reanchor", "camera": "left"}, people)["ok"]
    assert people.orders == [("reanchor",), ("reanchor", "left")]
    numbered = carry_out({"order": "reanchor", "camera": 3}, people)
    assert numbered["error"] == "camera: must be a name, not 3"
    people.refused["reanchor"] = "no picture has come from the camera yet"
    refused = carry_out({"order": "reanchor"}, people)
    assert refused == {"ok": False, "error": "no picture has come from the camera yet"}


def test_a_run_that_cannot_reanchor_says_so() -> None:
    cannot = carry_out({"order": "reanchor"}, People(None))
    assert "this run cannot place its camera again" in cannot["error"]


def test_the_answer_reaches_who_asks_through_the_socket(tmp_path: Path) -> None:
    people = RecordedPeople(reanchor=["anchored"])
    with ControlServer(tmp_path / "run" / "control.sock", people) as server:
        answer = send_order(server.path, {"order": "reanchor"})
    assert answer["anchoring"] == ["anchored"]


def test_a_calibration_that_was_written_anew_is_taken_over_by_a_reload(config_file: Path) -> None:
    said: list[str] = []
    fresh: list[Config] = []
    config = load_config(config_file, {})
    reloader = Reloader(
        config_file,
        config,
        load=lambda path: load_config(path, {}),
        say=lambda _, sentence: said.append(sentence),
        good=fresh.append,
    )
    file = config.camera.calibration
    assert file is not None
    file.write_text(file.read_text().replace("remarks: []", "remarks: [anchored again]"))
    reloader.ask()
    reloader.join(20.0)
    assert fresh == [config]
    assert "the calibration changed" in said[0]
    reloader.ask()
    reloader.join(20.0)
    assert "nothing has changed" in said[1]


def lens_of(size: tuple[int, int] = (1280, 960)) -> Lens:
    matrix = np.array([[1200.0, 0.0, 640.0], [0.0, 1200.0, 480.0], [0.0, 0.0, 1.0]])
    return Lens(size, matrix, np.zeros(5), 0.1, 5, (), (), "brown")


def test_a_lens_without_floor_markers_is_saved_alone_and_the_calibration_stays(
    config_file: Path,
) -> None:
    config = load_config(config_file, {})
    file = config.camera.calibration
    assert file is not None
    before = file.read_text()
    asked: list[None] = []
    said = take_over_lens(config, lens_of(), EMPTY, NOW, lambda: asked.append(None))
    assert "clearway calibrate --lens" in said
    assert file.read_text() == before
    assert asked == []
    alone = load_lens(file.with_name(f"{file.stem}.lens.20260102-000000.yaml"))
    assert alone.camera_matrix[0, 0] == 1200.0


def test_a_lens_is_not_taken_over_where_the_markers_are_not_seen_or_the_picture_is_another(
    config_file: Path,
) -> None:
    config = with_markers(load_config(config_file, {}), MARKERS)
    file = config.camera.calibration
    assert file is not None
    before = sorted(file.parent.iterdir())
    with pytest.raises(AnchoringError, match="no picture"):
        take_over_lens(config, lens_of(), None, NOW, None)
    with pytest.raises(AnchoringError, match="0 floor markers"):
        take_over_lens(config, lens_of(), EMPTY, NOW, None)
    with pytest.raises(AnchoringError, match="the lens is of 640 x 480 pixels"):
        take_over_lens(config, lens_of((640, 480)), EMPTY, NOW, None)
    assert sorted(file.parent.iterdir()) == before
