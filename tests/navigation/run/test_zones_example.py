"""configs/zones.yaml keeps what it promises, judged by where the robots really were."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from navigation.config import load_config
from navigation.loop.daemon import Daemon
from navigation.loop.run_state import RunState
from navigation.loop.zones_in_force import ZonesInForce
from navigation.run import run_folder
from navigation.run.run_folder import write_run
from navigation.run.run_report import RunReport
from navigation.run.virtual_run import run_virtually
from planner.roadmap.curves import curves_of
from planner.roadmap.roadmap import Roadmap

CONFIGS = Path(__file__).parents[3] / "configs"
RADIUS_M = 0.07


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Daemon, RunReport]:
    """The run, which is done and has left its picture."""
    daemons: list[Daemon] = []
    folder = tmp_path_factory.mktemp("zones")
    config = load_config(CONFIGS / "zones.yaml", {})

    def look(daemon: Daemon, _now: RunState) -> bool:
        daemons[:] = [daemon]
        return False

    report = run_virtually(config, pictures=False, look=look)
    assert report.state == "done"
    assert [one["name"] for one in report.as_json()["zones"]] == [z.name for z in config.zones]
    assert write_run(folder, daemons[0], report) == []
    picture = (folder / "track.svg").read_text()
    assert all(f">{name}" in picture for name in ("desk", "crossing", "alley", "road", "door"))
    return daemons[0], report


@pytest.fixture(scope="module")
def tracks(driven: tuple[Daemon, RunReport]) -> dict[str, np.ndarray]:
    """Rows of seconds, x_m, y_m of each robot."""
    return {name: one.track()[:, :3] for name, one in driven[0].world.truths.items()}


def test_the_picture_draws_no_roadmap_through_the_desk_and_one_through_a_zone_of_one_robot(
    driven: tuple[Daemon, RunReport], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    daemon, report = driven
    drawn: list[Roadmap] = []
    monkeypatch.setattr(run_folder, "save_picture", lambda *given, **_: drawn.append(given[2]))
    for robots in ((), ("ada",)):
        desk, *others = daemon.config.zones
        zones = ZonesInForce([desk.model_copy(update={"robots": robots}), *others], ["ada", "bob"])
        monkeypatch.setattr(daemon, "zones", zones)
        run_folder.write_picture(tmp_path / "track.svg", daemon, report)
    through = []
    for roadmap in drawn:
        curves = curves_of(roadmap)
        assert curves is not None
        through.append(bool((from_the_desk(curves.points) < RADIUS_M - 1e-6).any()))
    assert through == [False, True]


def from_the_desk(places: np.ndarray) -> np.ndarray:
    """Distance (n,) of places (n, 2) from the desk, 0 inside."""
    off = np.abs(places - (1.2, 1.52)) - (0.2, 0.1)
    return np.hypot(*np.maximum(off, 0.0).T)


def test_no_body_enters_the_desk(tracks: dict[str, np.ndarray]) -> None:
    for track in tracks.values():
        assert from_the_desk(track[:, 1:]).min() >= RADIUS_M


def test_the_crossing_is_driven_slowly_and_the_alley_to_the_right(
    tracks: dict[str, np.ndarray],
) -> None:
    ada = tracks["ada"]
    steps = np.diff(ada, axis=0)
    inside = np.hypot(ada[1:, 1] - 1.2, ada[1:, 2] - 0.9) < 0.15 + RADIUS_M
    assert inside.any(), "ada goes through the alley"
    assert np.hypot(steps[inside, 1], steps[inside, 2]).sum() > 0.3
    assert np.hypot(steps[inside, 1], steps[inside, 2]).sum() / steps[inside, 0].sum() < 0.15 * 1.05
    alley = (np.abs(ada[1:, 2] - 0.9) < 0.15) & (np.abs(ada[1:, 1] - 1.2) < 0.7)
    assert steps[alley, 1].min() > -1e-4


def test_bob_takes_its_lane(tracks: dict[str, np.ndarray]) -> None:
    bob = tracks["bob"]
    before = bob[bob[:, 1] > 0.6]
    assert (np.abs(before[:, 2] - 0.28) < 0.15).all()


def test_nobody_stands_at_the_door(tracks: dict[str, np.ndarray]) -> None:
    for track in tracks.values():
        inside = np.hypot(track[:, 1] - 2.15, track[:, 2] - 0.9) < 0.2
        rest_s = last_s = 0.0
        for (t0, x0, y0), (t1, x1, y1), is_in in zip(track, track[1:], inside, strict=False):
            still = bool(is_in) and math.dist((x0, y0), (x1, y1)) < 0.01 * (t1 - t0)
            last_s = last_s + t1 - t0 if still else 0.0
            rest_s = max(rest_s, last_s)
        assert rest_s < 0.5
