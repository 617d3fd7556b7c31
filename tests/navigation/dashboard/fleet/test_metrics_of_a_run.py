"""/metrics of `clearway run` with two robots that drive, as Prometheus would read it."""

from __future__ import annotations

import re
import signal
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from subprocess import PIPE

import pytest
import yaml
from prometheus_client.parser import text_string_to_metric_families

from navigation.mission.mission import State
from tests.navigation.loop.test_fleet_kill import hall
from tests.support.processes.forked import Program
from tests.support.waiting import wait_until

PAGE = re.compile(r"dashboard at (http://127\.0\.0\.1:\d+)/#token=(\S+)")
Samples = dict[tuple[str, str | None, str | None], float]
"""By metric, robot and state."""


@pytest.fixture
def page(tmp_path: Path) -> Iterator[tuple[str, str]]:
    """The address and token of a run whose robots have a path."""
    config = hall(tmp_path / "journal", "ab").model_dump(mode="json", exclude_none=True)
    config["camera"]["rate_hz"] = 10.0  # which a busy machine keeps up with
    config["simulation"]["time_limit_s"] = 120.0
    config["dashboard"] = {"port": 0}
    (tmp_path / "hall.yaml").write_text(yaml.safe_dump(config))
    arguments = ("run", "hall.yaml", "--socket", "c.sock")
    with Program(arguments, cwd=tmp_path, stdout=PIPE) as process:
        assert process.stdout is not None
        said = ""
        while not PAGE.search(said):
            line = process.stdout.readline()
            assert line, f"it ended: {said}"
            said += line
        found = PAGE.search(said)
        assert found
        yield found[1], found[2]
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=60)


def scrape(page: tuple[str, str]) -> Samples:
    address, token = page
    request = urllib.request.Request(
        f"{address}/metrics", headers={"Authorization": f"Bearer {token}"}
    )
    with urllib.request.urlopen(request, timeout=10.0) as answer:
        assert answer.headers["Content-Type"].startswith("text/plain")
        text = answer.read().decode()
    return {
        (sample.name, sample.labels.get("robot"), sample.labels.get("state")): sample.value
        for family in text_string_to_metric_families(text)
        for sample in family.samples
    }


def test_both_robots_have_their_own_numbers_while_they_drive(page: tuple[str, str]) -> None:
    def both_drive() -> bool:
        told = scrape(page)
        driving = State.DRIVING.value
        return all(told.get(("clearway_mission_state", one, driving)) == 1.0 for one in "ab")

    assert wait_until(both_drive, 120.0)
    first = scrape(page)
    for one in "ab":
        assert first["clearway_link_up", one, None] == 1.0
        assert first["clearway_robot_estopped", one, None] == 0.0
        assert first["clearway_mission_stations", one, None] == 2.0
        assert 0.0 < first["clearway_to_go_metres", one, None] < 5.0
        assert 0.0 < first["clearway_clearance_metres", one, None] < 1.0
        states = [first["clearway_mission_state", one, state.value] for state in State]
        assert sum(states) == 1.0
    assert first["clearway_camera_up", None, None] == 1.0
    assert ("clearway_to_go_metres", None, None) not in first

    def has_gone_on() -> bool:
        now = scrape(page)
        return (
            all(
                now[metric, one, None] > first[metric, one, None]
                for metric in (
                    "clearway_link_frames_sent_total",
                    "clearway_link_frames_received_total",
                )
                for one in "ab"
            )
            and now["clearway_camera_frames_total", None, None]
            > first["clearway_camera_frames_total", None, None]
        )

    assert wait_until(has_gone_on, 30.0)
    assert (
        scrape(page)["clearway_run_seconds", None, None] > first["clearway_run_seconds", None, None]
    )
