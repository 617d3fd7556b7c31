"""What the guides say is so: links lead somewhere, commands exist, sentences are the program's."""

import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from navigation.cli.main import COMMANDS
from navigation.config.reference import json_schema
from tests.support.pictures import call
from vision.camera.camera import Camera, CameraError
from vision.camera.latest_frame import LatestFrame

ROOT = Path(__file__).parents[3]
GUIDES = ["first_hour", "troubleshooting", "writing_a_robot_port", "writing_a_camera_source"]
DOCUMENTS = [ROOT / "README.md", *(ROOT / "docs" / f"{name}.md" for name in GUIDES)]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_link_leads_to_a_file(document: Path) -> None:
    text = document.read_text()
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        if not target.startswith("http"):
            assert (document.parent / target).exists(), target
    for name in re.findall(r"`((?:docs|configs|tests|navigation|vision|planner)/[\w./-]+)`", text):
        assert (ROOT / name).exists(), name


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_command_exists(document: Path) -> None:
    for name in re.findall(r"\bclearway ([a-z][a-z-]+)\b", document.read_text()):
        assert name in COMMANDS, name


@pytest.mark.parametrize("name", ["first_hour", "troubleshooting"])
def test_every_key_of_the_configuration_exists(name: str) -> None:
    sections = json_schema()["properties"]
    defined = json_schema()["$defs"]
    text = (ROOT / "docs" / f"{name}.md").read_text()
    named = re.findall(r"`([a-z_]+)\.([a-z_]+)(?::[^`]*)?`", text)
    found = [(section, key) for section, key in named if section in sections]
    assert len(found) > 5
    for section, key in found:
        reference = re.search(r"\$defs/(\w+)", str(sections[section]))
        assert reference is not None
        assert key in defined[reference[1]]["properties"], f"{section}.{key}"


def test_every_sentence_in_the_troubleshooting_is_one_of_the_programs() -> None:
    folders = (ROOT / name for name in ("navigation", "vision", "planner", "firmware_protocol"))
    files = [path for folder in folders for path in folder.rglob("*")]
    source = "\n".join(p.read_text() for p in files if p.suffix in (".py", ".js", ".html"))
    # as it reads when strings over several lines are joined
    source = re.sub(r'"\s*\n\s*f?"', "", source)
    rows = re.findall(r"^\| `([^`]+)` ", (ROOT / "docs/troubleshooting.md").read_text(), re.M)
    assert len(rows) > 12
    for sentence in rows:
        for piece in re.split(r"\.\.\.|: |[<=>]|127\S+|8421:?", sentence):
            words = piece.strip()
            if len(words) > 10:
                assert words in source, words


def test_the_camera_of_the_guide_works_as_it_stands_there(tmp_path: Path) -> None:
    text = (ROOT / "docs/writing_a_camera_source.md").read_text()
    example = re.findall(r"```python\n(from pathlib.*?)```", text, re.S)[0]
    names: dict[str, type] = {}
    exec(compile(example, "the guide", "exec"), names)
    now_s = [1.0]

    def make() -> Camera:
        return names["SpoolCamera"](tmp_path / "spool", lambda: now_s[0], lambda _s: None)  # type: ignore[no-any-return]

    with pytest.raises(CameraError, match="no such folder"):
        make().open()
    (tmp_path / "spool").mkdir()
    reader = LatestFrame(make, lambda: now_s[0])
    for number in range(3):
        image = np.full((20, 30, 3), 50 * number, np.uint8)
        cv2.imwrite(str(tmp_path / "spool" / f"{number}.png"), image)
        for _ in range(4):
            now_s[0] += 0.05
            reader.step()
        frame = reader.take()
        assert frame is not None
        assert frame.image[0, 0, 0] == 50 * number
        assert frame.captured_s <= now_s[0]
    assert reader.status().state == "running"
    reader.stop()


def test_the_starters_of_the_first_hour_are_good_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call("init", "demo.yaml").code == 0
    assert call("check", "demo.yaml").code == 0
    assert call("init", "--real", "arena.yaml").code == 0
    told = call("check", "arena.yaml")
    assert told.code == 78
    assert "calibration.yaml" in told.err, "what is left to do is the calibration"
