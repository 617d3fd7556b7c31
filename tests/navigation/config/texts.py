"""A configuration that is right, and what a wrong one is told."""

from __future__ import annotations

import pytest

from navigation.config import ConfigError, parse_config

GOOD = """\
arena:
  bounds_m: [0, 0, 2.4, 1.8]
camera:
  source: simulated
robot:
  marker_id: 7
  marker_size_m: 0.09
  radius_m: 0.09
simulation:
  arena_text: "C (1,1) 0.2"
  start: {x_m: 0.2, y_m: 0.2}
"""


def problems_of(text: str, **environment: str) -> list[tuple[str, str]]:
    """(key, message) of every problem."""
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml", None, environment)
    return [(problem.key, problem.message) for problem in caught.value.problems]


def the_problem(text: str, **environment: str) -> tuple[str, str]:
    (problem,) = problems_of(text, **environment)
    return problem


def text_of_error(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        parse_config(text, "run.yaml")
    return str(caught.value)
