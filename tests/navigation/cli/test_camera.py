"""`clearway camera` on cameras that are not there, files, and the simulated one."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from navigation.cli.main import run
from tests.support.processes.mjpeg_server import mjpeg_server
from tests.support.processes.v4l2_preloaded import NEEDS_GCC, ROOT, environment, jpegs, video_nodes

PROGRAM = Path(sys.executable).with_name("clearway")
WEBCAM = "YUYV:1280x960@10,640x480@30;MJPG:1280x960@30@15,640x480@30"


def camera(node: Path, *arguments: str, **more: str) -> subprocess.CompletedProcess[str]:
    """The command on a camera of the preloaded library; devices have to begin with /dev/."""
    source = Path("/dev/..") / node.relative_to("/")
    return subprocess.run(
        [PROGRAM, "camera", str(source), *arguments],
        env=environment([source, node], V4L2_MODES=WEBCAM, V4L2_DELIVER="1", **more),
        cwd=ROOT, capture_output=True, text=True, timeout=120,
    )  # fmt: skip


@pytest.fixture
def node(tmp_path: Path) -> Path:
    return next(video_nodes(tmp_path, "video0"))


@NEEDS_GCC
def test_a_device_s_table_sentences_and_section(node: Path) -> None:
    # one picture: several in turn are a light that flickers
    files = jpegs(node.parent, (1280, 960)).split(":")[0]
    done = camera(node, "--seconds", "2", V4L2_JPEGS=files)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[:4] == ["it offers:", "  YUYV  1280x960    10", "  YUYV  640x480    30",
                         "  MJPG  1280x960    30, 15"]  # fmt: skip
    assert "taken: MJPG 1280x960 at 30 frames/s" in lines
    assert "ok    size          1280x960" in lines
    assert "ok    damage        no damaged picture" in lines
    assert lines[lines.index("camera:") + 2 :] == [
        "  size_px: [1280, 960]", "  rate_hz: 30", "  format: auto", "  mains_hz: 50",
        "  exposure_ms: auto", "  focus: auto",
    ]  # fmt: skip


@NEEDS_GCC
def test_what_is_wrong_is_said_with_its_cure(node: Path) -> None:
    files = jpegs(node.parent, (1280, 960))
    done = camera(
        node, "--seconds", "3", "--format", "json",
        V4L2_JPEGS=files, V4L2_REAL_HZ="12", V4L2_FAULT="cut", V4L2_EVERY="4",
    )  # fmt: skip
    told = json.loads(done.stdout)
    assert told["schema"] == "clearway.camera/1"
    findings = {finding["name"]: finding for finding in told["findings"]}
    assert findings["rate"]["status"] == "warn"
    assert "camera.rate_hz asks for 30" in findings["rate"]["sentence"]
    assert findings["damage"]["cure"] == "a shorter cable, or another USB port; no hub"
    assert told["measured"]["damaged"] >= 5
    assert told["modes"][0] == {"fourcc": "YUYV", "size": [1280, 960], "rates_hz": [10.0]}


@NEEDS_GCC
def test_an_unknown_size_fails(node: Path) -> None:
    done = camera(node, "--seconds", "1", "--size", "800x600")
    assert done.returncode == 1
    assert "640x480, camera.size_px asks for 800x600" in done.stdout
    assert "-> set camera.size_px to [640, 480], and calibrate at this size" in done.stdout


@pytest.fixture
def config(tmp_path: Path) -> Path:
    for name in ("simulation.yaml", "simulation_calibration.yaml"):
        shutil.copy(ROOT / "configs" / name, tmp_path / name)
    shutil.copytree(ROOT / "configs" / "arenas", tmp_path / "arenas")
    return tmp_path / "simulation.yaml"


def test_a_simulated_camera_is_judged_drawn_and_written(
    config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = config.read_text()
    picture = config.with_name("judged.png")
    arguments = ["camera", str(config), "--seconds", "2", "--rate", "25"]
    assert run([*arguments, "--render", str(picture), "--write", str(config)]) == 0
    told = capsys.readouterr().out
    assert "ms from the exposure to the program" in told
    assert "marker 7" in told
    assert "100 % of it is in focus" in told
    drawn = cv2.imread(str(picture))
    assert drawn is not None
    assert drawn.shape == (960, 1280, 3)
    assert np.ptp(drawn.astype(int), axis=2).max() > 100, "in colours"
    after = config.read_text()
    changed = [b for a, b in zip(before.splitlines(), after.splitlines(), strict=True) if a != b]
    assert changed == ["  rate_hz: 25"]


def test_a_stream_s_password_is_not_printed(capsys: pytest.CaptureFixture[str]) -> None:
    with mjpeg_server() as server:
        url = server.url.replace("http://", "http://me:hunter2@")
        for form in ("text", "json"):
            assert run(["camera", url, "--seconds", "1", "--size", "64x48", "--format", form]) == 0
            told = capsys.readouterr()
            assert "a stream does not say how old its pictures are" in told.out
            assert "hunter2" not in told.out + told.err


def test_files_and_folders_say_what_cannot_be_known(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    jpegs(tmp_path, (640, 480))
    single = tmp_path / "picture0.jpg"
    assert run(["camera", str(single), "--seconds", "1", "--size", "640x480"]) == 0
    told = capsys.readouterr().out
    assert "noise         cannot be measured: the pictures do not change" in told
    assert "the pace at which a file is read" in told
    assert run(["camera", str(tmp_path), "--seconds", "1", "--size", "640x480"]) == 0
    assert "a file's pace is not its camera's" in capsys.readouterr().out


def test_without_a_size_any_is_right(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    jpegs(tmp_path, (640, 480))
    assert run(["camera", str(tmp_path), "--seconds", "1"]) == 0
    told = capsys.readouterr().out
    assert "asks for" not in told
    assert "size_px: [640, 480]" in told


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["simulated"], 2, "a simulated camera needs its configuration: name the file"),
        (["/dev/video987"], 2, "/dev/video987 does not exist; is it plugged in?"),
        (["missing.png"], 2, "missing.png: no such file, folder or camera"),
        (["missing.yaml"], 78, "missing.yaml: No such file or directory"),
        (["0", "--size", "big"], 2, "'big': must be WxH, as in 1280x960"),
        (["0", "--size", "1x1"], 2, "sides must be 16..32768"),
        (["0", "--rate", "1e9"], 2, "must be in 0.001..1000"),
        (["0", "--seconds", "1e9"], 2, "must be <= 3600"),
    ],
)
def test_errors_are_sentences(
    arguments: list[str], code: int, sentence: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["camera", *arguments]) == code
    assert sentence in capsys.readouterr().err


def test_without_a_source_the_one_camera_is_taken_or_all_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from navigation.cli.setup import devices

    def plug(*names: str) -> None:
        listed: list[dict[str, Any]] = [{"path": name, "name": "Camera"} for name in names]
        monkeypatch.setattr(devices, "cameras_here", lambda: listed)

    plug()
    assert run(["camera"]) == 2
    assert "no camera is plugged in: name a source" in capsys.readouterr().err
    plug("/dev/v4l/by-id/a", "/dev/v4l/by-id/b")
    assert run(["camera"]) == 2
    assert "name one of /dev/v4l/by-id/a, /dev/v4l/by-id/b" in capsys.readouterr().err
    plug("/dev/v4l/by-id/a")
    assert run(["camera"]) == 2
    assert "camera /dev/v4l/by-id/a: /dev/v4l/by-id/a does not exist" in capsys.readouterr().err
