"""Every configuration that a document prints is one that the program accepts.

A block of a page that begins with keys of a configuration is a whole one or a part of one; a
part is completed by the sections that it does not have.
"""

import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from navigation.config import parse_config
from navigation.config.sections import Config

ROOT = Path(__file__).parents[2]
REST = {
    "arena": {"bounds_m": [0, 0, 2.4, 1.8]},
    "camera": {"source": "/dev/video0", "calibration": "calibration.yaml"},
    "robot": {"marker_id": 0, "marker_size_m": 0.07, "radius_m": 0.07},
    "serial": {"port": "/dev/ttyUSB0"},
}
ROBOTS = [
    {"name": name, "marker_id": number, "port": f"/dev/ttyUSB{number}"}
    for number, name in enumerate(("ada", "bob"), 1)
]
SIMULATED = {
    "camera": {"source": "simulated"},
    "simulation": {"arena_text": "C (1,1) 0.1", "start": {"x_m": 0.2, "y_m": 0.2}},
}


def printed() -> list[Any]:
    found = []
    for page in sorted([ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]):
        text = page.read_text(encoding="utf-8")
        for block in re.finditer(r"^```yaml\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
            data = yaml.safe_load(block[1])
            if isinstance(data, dict) and data.keys() <= Config.model_fields.keys():
                line = text.count("\n", 0, block.start()) + 2
                found.append(pytest.param(block[1], id=f"{page.relative_to(ROOT)}:{line}"))
    return found


def completed(text: str) -> str:
    """The printed block, and the sections that it needs and does not have."""
    data = yaml.safe_load(text)
    rest: dict[str, Any] = dict(REST)
    if "simulation" in data:
        rest |= SIMULATED
        data["simulation"] = SIMULATED["simulation"] | data["simulation"]
    if "robots" in data:
        del rest["serial"]  # the list says where its robots are
    if "tasks" in data and "robots" not in data:
        rest["robots"] = ROBOTS
    return yaml.safe_dump(rest | data)


@pytest.mark.parametrize("block", printed())
def test_a_configuration_in_a_document_is_accepted(block: str) -> None:
    parse_config(completed(block), "printed.yaml")


def test_documents_print_configurations() -> None:
    assert len(printed()) >= 6
