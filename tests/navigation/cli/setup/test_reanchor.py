"""``clearway reanchor``: pictures, a source in place of the camera, and the running daemon."""

from __future__ import annotations

import json
import socket
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from tests.support.drawn.floor import (
    MARKER_M,
    PLACES,
    SIZE,
    floor_texture,
    hanging,
    photograph,
)
from vision.calibration.calibration_file import load_calibration, save_calibration

HIGH_M = (1.02, 0.74, 3.2)
"""Where the whole arena of the configuration is seen."""


@pytest.fixture
def config(config_file: Path) -> Path:
    """A configuration with the markers of the drawn floor."""
    lines = [
        f"    - {{marker_id: {i}, size_m: {MARKER_M}, place_m: [{x}, {y}], heading_deg: 0}}"
        for i, (x, y) in PLACES.items()
    ]
    text = config_file.read_text()
    arena = "arena:\n  floor_markers:\n" + "\n".join(lines) + "\n"
    text = text.replace("arena:\n", arena, 1).replace("[1280, 960]", f"[{SIZE[0]}, {SIZE[1]}]", 1)
    config_file.write_text(text)
    save_calibration(hanging(at_m=HIGH_M), config_file.with_name("simulation_calibration.yaml"))
    return config_file


def test_a_picture_places_the_camera_and_the_file_before_is_kept(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = hanging((2.0, -1.0), 2.0, HIGH_M)
    picture = config.with_name("floor.png")
    cv2.imwrite(str(picture), photograph(truth, floor_texture(), np.random.default_rng(3)))
    file = config.with_name("simulation_calibration.yaml")
    before = file.read_text()
    assert run(["reanchor", str(config), str(picture)]) == 0
    said = capsys.readouterr().out
    assert "floor marker 20: 0." in said
    assert "anchored by 5 floor markers" in said
    (kept,) = config.parent.glob("simulation_calibration.*-*.yaml")
    assert kept.read_text() == before
    places = [(0.2, 0.2), (1.8, 1.3)]
    found = load_calibration(file).arena_from_image(truth.image_from_arena(places))
    assert abs(found - places).max() < 0.002


@pytest.mark.parametrize(
    ("named", "order"),
    [
        ([], {"order": "reanchor"}),
        (["--camera", "left"], {"order": "reanchor", "camera": "left"}),
    ],
)
def test_the_running_daemon_is_asked_without_a_configuration(
    named: list[str], order: dict[str, str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "control.sock"
    asked: list[bytes] = []

    def answer() -> None:
        connection, _ = server.accept()
        asked.append(connection.recv(4096))
        connection.sendall(json.dumps({"ok": True, "anchoring": ["anchored"]}).encode() + b"\n")
        connection.close()

    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as server:
        server.bind(str(path))
        server.listen(1)
        thread = threading.Thread(target=answer)
        thread.start()
        assert run(["reanchor", "--socket", str(path), *named]) == 0
        thread.join(5.0)
    assert capsys.readouterr().out == "anchored\n"
    assert json.loads(asked[0]) == order


def test_a_socket_beside_a_configuration_is_refused(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["reanchor", str(config), "--socket", "x"]) == 2
    assert "without CONFIG" in capsys.readouterr().err
