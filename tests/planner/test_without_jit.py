"""The planner's kernels are their own reference: as plain Python they answer alike."""

from tests.support.without_jit import answers_differ

PLANNED = """
import json, warnings
import planner
from planner.scene import Bounds, CircleRecord, PolygonRecord, Scene, SceneObject, Segment
# indices that count backwards wrap around on purpose
warnings.filterwarnings("ignore", "overflow encountered", RuntimeWarning)

def polygon(*corners):
    ends = (*corners[1:], corners[0])
    return PolygonRecord(tuple(map(Segment, corners, ends)))

scene = Scene("m", Bounds(0.0, 0.0, 3.0, 2.0), (
    SceneObject(0, (polygon((0.8, 0.0), (1.0, 0.0), (1.0, 1.2), (0.8, 1.2)),)),
    SceneObject(1, (CircleRecord((2.0, 1.1), 0.3),)),
))
roadmap = planner.build_roadmap(scene, radius=0.15)
answers = {}
for prefer in ("clearance", "balanced", "length"):
    path = roadmap.plan((0.4, 0.4), (2.6, 0.5), prefer=prefer, alternatives=1)
    answers[prefer] = {
        "points": path.points.tolist(),
        "length": path.length,
        "min_clearance": path.min_clearance,
    }
none = planner.build_roadmap(scene, radius=0.45).plan((0.4, 0.4), (2.6, 0.5))
answers["too large"] = none.reason
print(json.dumps(answers))
"""


def test_roadmap_and_plans_are_the_same_without_the_compiler() -> None:
    assert answers_differ(PLANNED) == []
