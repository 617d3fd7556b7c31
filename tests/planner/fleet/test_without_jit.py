"""The fleet's kernels are their own reference: as plain Python they answer alike."""

import pytest

from tests.support.without_jit import COLD_S, answers_differ

pytestmark = pytest.mark.timeout(2 * COLD_S)

PLANNED = """
import json
from planner import plan_on_graph
nodes = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (1.0, 1.0), (3.0, 0.0)]
edges = [(0, 1), (1, 2), (2, 3), (1, 4), (3, 5)]
edges += [(b, a) for a, b in edges]
answers = {}
for starts, goals in (([0, 2], [2, 0]), ([0, 1], [5, 1]), ([0, 3], [3, 0])):
    plan = plan_on_graph(nodes, edges, 0.3, starts, goals)
    answers[str(starts)] = [track.tolist() for track in plan.tracks] + [plan.dependencies]
answers["none"] = plan_on_graph(nodes[:2], [(0, 1), (1, 0)], 0.3, [0, 1], [1, 0]).reason
print(json.dumps(answers))
"""


def test_plans_are_the_same_without_the_compiler() -> None:
    assert answers_differ(PLANNED) == []
