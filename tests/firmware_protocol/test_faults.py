"""A fast part of the fault matrix; ``benchmarks/faults.py`` runs it over many seeds."""

import pytest

from tests.support.wire.fault_scenarios import SCENARIOS


@pytest.mark.parametrize("name", SCENARIOS)
def test_link_survives(name: str) -> None:
    outcome = SCENARIOS[name](3)
    assert "executed" in outcome or "said so" in outcome
