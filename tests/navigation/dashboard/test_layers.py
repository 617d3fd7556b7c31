"""The clearance of every place, and the camera's own picture with what was found in it."""

import json

import cv2
import numpy as np

import planner
from navigation.dashboard.messages.camera_view import CameraView
from navigation.dashboard.messages.geometry import world_message
from navigation.dashboard.messages.heat import BLOCKED, CELLS, TIGHT, heat_message
from navigation.draw.shapes import RAMP_STEPS
from planner.formats.scene_io import load_scene
from planner.formats.scene_json import scene_to_json
from planner.scene import Bounds
from planner.zones.areas import CircleArea
from planner.zones.zone import Zone
from planner.zones.zoned_roadmap import with_zones
from tests.navigation.dashboard.site import Site
from tests.support.oracles.brute_clearance import borders, distances, inside, outline
from tests.support.runs.packed import unpack
from tests.support.runs.shown import RADIUS_M, ROOT, SCALE_M, SIZE_PX, frame, laboratory, pose
from tests.support.waiting import wait_until
from vision.calibration.calibration import Calibration

WINDOW = Bounds(-0.1, -0.1, 2.5, 1.9)
ARENA = Bounds(0.0, 0.0, 2.4, 1.8)


def test_every_cell_has_the_clearance_of_its_middle() -> None:
    head, arrays = unpack(heat_message(with_zones(laboratory(), ()), WINDOW, 3))
    columns, rows, steps = head["columns"], head["rows"], arrays["steps"]
    assert head["number"] == 3
    assert 0.9 * CELLS < columns * rows <= CELLS
    assert len(steps) == columns * rows
    at = np.random.default_rng(1).choice(len(steps), 400, replace=False)
    x = -0.1 + (at % columns + 0.5) * 2.6 / columns
    y = 1.9 - (at // columns + 0.5) * 2.0 / rows
    scene = json.loads(
        json.dumps(scene_to_json(load_scene(ROOT / "configs/arenas/laboratory.txt")))
    )
    places = np.stack([x, y], axis=1)
    clearance = distances(places, scene, y_down=False)
    blocked = ~((x > 0.0) & (x < 2.4) & (y > 0.0) & (y < 1.8))
    for records in borders(scene):
        blocked |= inside(places, outline(records, y_down=False))
    clearance[blocked] *= -1.0
    known = steps[at]
    sure = np.abs(clearance) > 1e-3
    np.testing.assert_array_equal((known == BLOCKED)[sure], (clearance < 0.0)[sure])
    tight = (clearance >= 0.0) & (clearance < RADIUS_M)
    clear_cut = np.abs(clearance - RADIUS_M) > 1e-3
    np.testing.assert_array_equal((known == TIGHT)[sure & clear_cut], tight[sure & clear_cut])
    on_ramp = known < RAMP_STEPS
    order = np.argsort(clearance[on_ramp])
    assert (np.diff(known[on_ramp][order].astype(int)) >= -1).all()
    ramp = steps[steps < RAMP_STEPS]
    assert ramp.min() == 0
    assert ramp.max() >= RAMP_STEPS - 2, "the widest place is no cell's middle"


def test_zones_change_no_clearance_and_the_colours_are_those_of_the_roadmaps_lines() -> None:
    window = CircleArea((2.0, 1.4), 0.25)  # over the widest place of the roadmap
    zoned = with_zones(laboratory(), [Zone("desk", "keep_out", window)])
    _, plain = unpack(heat_message(with_zones(laboratory(), ()), WINDOW, 1))
    head, arrays = unpack(heat_message(zoned, WINDOW, 2))
    for code in (BLOCKED, TIGHT):
        np.testing.assert_array_equal(plain["steps"] == code, arrays["steps"] == code)
    _, world = unpack(world_message(zoned, 1))
    usable = np.repeat(world["chain_usable"], np.diff(world["chain_first"])).astype(bool)
    low, high = (float(f(world["chain_clearance"][usable])) for f in (np.min, np.max))
    columns, rows = head["columns"], head["rows"]
    at = np.flatnonzero(arrays["steps"] < RAMP_STEPS)[::50]
    x = -0.1 + (at % columns + 0.5) * 2.6 / columns
    y = 1.9 - (at // columns + 0.5) * 2.0 / rows
    shares = (laboratory().clearance(np.column_stack([x, y])) - low) / (high - low)
    expected = np.clip(shares * (RAMP_STEPS - 1), 0, RAMP_STEPS - 1)
    assert np.abs(arrays["steps"][at] - expected).max() <= 0.51


def test_what_was_found_lies_in_the_camera_picture_where_it_was_found() -> None:
    view = CameraView(Calibration.from_scale(SCALE_M, SIZE_PX), ARENA, 240, 90)
    robot = pose(1.0, 0.5)
    fields = {"number": 4, "age_ms": 1.0}
    made = view.messages(frame(9), {7: robot}, laboratory(), (60, 240, 960), fields)
    head, arrays = unpack(made[240])
    assert (head["type"], head["number"], head["ids"]) == ("camera", 4, [7])
    assert head["size_px"] == [240, 180]
    for width, shape in ((60, (45, 60)), (240, (180, 240)), (960, (180, 240))):
        same, others = unpack(made[width])
        assert cv2.imdecode(others["jpeg"], cv2.IMREAD_UNCHANGED).shape[:2] == shape
        assert same["size_px"] == head["size_px"], "one frame for what is drawn, whatever its size"
        np.testing.assert_array_equal(others["border"], arrays["border"])
    # a picture of half the size: a pixel is 1 cm, and the first one's middle is half of that in
    np.testing.assert_allclose(arrays["corners"].reshape(4, 2), [[99.5, 129.5]] * 4, atol=1e-4)
    first, border = arrays["border_first"], arrays["border"].reshape(-1, 2)
    assert len(first) - 2 == 7, "the arena's rim, and seven obstacles"
    rim = border[first[0] : first[1]]
    np.testing.assert_allclose(rim.min(axis=0), [-0.5, -0.5], atol=1e-3)
    np.testing.assert_allclose(rim.max(axis=0), [239.5, 179.5], atol=1e-3)
    scene = laboratory().scene
    assert scene.objects, "what is drawn"
    inside = border[first[1] :]
    assert (inside > 0.0).all()
    assert (inside < (240, 180)).all()


def test_they_are_made_only_while_somebody_looks(site: Site) -> None:
    hub = site.dashboard.hub
    assert hub is not None
    with site.live() as page:
        page.join()
        page.send(type="watch", on=True)
        page.hear("picture")
        assert hub.heat.number == 0
        assert ("camera", 160) not in hub.pictures
        page.send(type="watch", on=True, camera=True, heat=True)
        heat = page.hear("heat")
        assert heat["columns"] * heat["rows"] == len(heat["arrays"]["steps"])
        site.daemon.show(frame=frame(2))
        camera = page.hear("camera")
        assert camera["ids"] == [7]
        page.send(type="ack")
        page.send(type="ack")
        for number in range(3, 9):
            site.daemon.show(frame=frame(number))
            page.send(type="ack")
            page.hear("camera")
            assert hub.pictures.keys() == {("camera", 160)}
        page.send(type="watch", on=False)
        page.send(type="ping", id=1)
        page.hear("pong")
        made = hub.picture_number, hub.heat.number
        another = planner.build_roadmap(laboratory().scene, RADIUS_M)
        site.daemon.show(frame=frame(20), roadmap=another)
        assert wait_until(lambda: hub.world.number == 2)
        assert (hub.picture_number, hub.heat.number) == made
