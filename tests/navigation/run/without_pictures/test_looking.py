"""What only pictures show is refused without them, and never left out silently."""

from __future__ import annotations

from typing import Any

import pytest

from navigation.config import Config, load_config
from navigation.run.virtual_world import VirtualWorld
from tests.support.runs.virtual import CONFIGS, short_config

NEAR = [{"x_m": 0.20, "y_m": 0.60}]


def knocked() -> Config:
    base = short_config(NEAR)
    assert base.simulation is not None
    camera: dict[str, Any] = base.simulation.camera.model_dump()
    camera["knocks"] = ({"from_s": 2.0, "tilt_deg": (1.0, 0.0)},)
    return short_config(NEAR, simulation={"camera": camera})


def with_a_floor_marker() -> Config:
    marker = {"marker_id": 20, "size_m": 0.06, "place_m": (2.0, 0.3)}
    return short_config(NEAR, arena={"floor_markers": (marker,)})


def badly_calibrated() -> Config:
    base = short_config(NEAR)
    return base.model_copy(
        update={"camera": base.camera.model_copy(update={"metres_per_pixel": 0.004})}
    )


@pytest.mark.parametrize(
    ("config", "words"),
    [
        (knocked, "only a picture shows that a camera was knocked"),
        (with_a_floor_marker, "arena.floor_markers: only a picture shows them"),
        (badly_calibrated, "its calibration is off by up to"),
    ],
)
def test_what_only_pictures_show_is_refused_without_them(config: Any, words: str) -> None:
    with pytest.raises(ValueError, match=words) as raised:
        VirtualWorld(config(), pictures=False)
    assert str(raised.value).endswith("draw pictures for this run")
    VirtualWorld(config())


def test_an_arena_that_is_emptied_needs_pictures() -> None:
    bucket = {"record": "C (0.5,0.5) 0.1", "until_s": 2.0}
    bare = "#@ clearway.scene/1\n#@ units m\nC (1.5,1.5) 0.1\n"
    two = {"record": "C (1.9,0.5) 0.1", "until_s": 2.0}
    config = short_config(
        NEAR, simulation={"arena": None, "arena_text": bare, "obstacles": (bucket, two)}
    )
    with pytest.raises(ValueError, match="takes away more than half"):
        VirtualWorld(config, pictures=False)


def test_a_real_calibration_of_the_simulated_camera_is_good_enough() -> None:
    VirtualWorld(load_config(CONFIGS / "simulation.yaml", {}), pictures=False)
