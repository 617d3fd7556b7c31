"""A world around the pilot."""

import pytest

from navigation.mission.pilot import Pilot
from tests.navigation.mission.world import SETTINGS, World


@pytest.fixture
def world() -> World:
    return World(Pilot(SETTINGS, first_mission_id=7))
