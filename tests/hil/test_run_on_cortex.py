"""A whole `clearway run` with the Cortex-M binary as the robot, in real time."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.robots.cortex_robot import CortexBuild, missing_tools
from tests.support.robots.emulated_run import assert_run_reaches_its_goal

pytestmark = [
    pytest.mark.timed,  # the emulated processor has to keep up with the clock
    pytest.mark.skipif(missing_tools() is not None, reason=f"needs {missing_tools()}"),
]


def test_clearway_run_drives_the_emulated_cortex_m_to_its_goal(tmp_path: Path) -> None:
    with CortexBuild() as build:
        assert_run_reaches_its_goal(tmp_path, build.command, has_own_time=True)
