"""What a run asks of a camera is what its configuration says."""

from __future__ import annotations

from pathlib import Path

import pytest

from navigation.config.errors import ConfigError
from navigation.config.load import parse_config
from tests.support.processes.v4l2_preloaded import NEEDS_GCC, ROOT, jpegs, run, video_nodes

OPEN = """
import json, sys
from pathlib import Path
from navigation.config.load import parse_config
from navigation.run.world import World
from vision.camera.v4l2.controls import list_controls
config = parse_config(Path(sys.argv[1]).read_text(), "a.yaml", Path("configs").absolute())
world = World(config)
camera = world.open_camera()
camera.open()
frame = camera.read(5.0)
told = {"shape": frame.image.shape, "mode": camera.mode.fourcc, "reason": camera.reason}
told["values"] = {one.name: one.value for one in list_controls(camera.node)}
camera.close()
world.stop()
print(json.dumps(told))
"""


@NEEDS_GCC
def test_a_run_opens_its_camera_with_the_keys_of_the_configuration(tmp_path: Path) -> None:
    (node,) = video_nodes(tmp_path, "video0")
    source = Path("/dev/..") / node.relative_to("/")
    text = (ROOT / "configs" / "simulation.yaml").read_text()
    keys = "exposure_ms: 8.3\n  gain: 12\n  focus: 40\n  white_balance_k: 4000\n  mains_hz: 60"
    asked = f"source: {source}\n  format: mjpg\n  {keys}\n  rolling_shutter_ms: 20"
    text = text.replace("source: simulated", asked, 1)
    file = tmp_path / "arena.yaml"
    file.write_text(text)
    told = run(
        OPEN, [source, node], file,
        V4L2_MODES="YUYV:1280x960@30;MJPG:1280x960@30", V4L2_DELIVER="1",
        V4L2_JPEGS=jpegs(tmp_path, (1280, 960)),
    )  # fmt: skip
    assert told["shape"] == [960, 1280], "grey: a run looks at nothing else"
    assert (told["mode"], told["reason"]) == ("MJPG", "")
    values = told["values"]
    assert values["Exposure Time, Absolute"] == 83
    assert (values["Gain"], values["Focus, Absolute"]) == (12, 40)
    assert (values["White Balance Temperature"], values["Power Line Frequency"]) == (4000, 2)
    assert values["Auto Exposure"] == 1


def test_a_simulated_camera_has_no_rolling_shutter() -> None:
    text = (ROOT / "configs" / "simulation.yaml").read_text()
    text = text.replace("source: simulated", "source: simulated\n  rolling_shutter_ms: 20", 1)
    with pytest.raises(ConfigError, match="must be 0, not 20: the simulated camera has none"):
        parse_config(text, "a.yaml", ROOT / "configs", {})


@pytest.mark.parametrize("key", ["exposure_ms", "gain", "focus", "white_balance_k"])
@pytest.mark.parametrize("value", ["-1", "true", "often", ".nan", "[1]"])
def test_a_control_is_auto_or_a_number(key: str, value: str) -> None:
    text = (ROOT / "configs" / "simulation.yaml").read_text()
    text = text.replace("source: simulated", f"source: simulated\n  {key}: {value}", 1)
    with pytest.raises(ConfigError, match=rf"camera.{key}: must be 'auto' or a number in"):
        parse_config(text, "a.yaml", ROOT / "configs", {})
