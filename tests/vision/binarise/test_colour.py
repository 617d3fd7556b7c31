"""Obstacles that only their colours tell from the floor, and floors that only seem coloured."""

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

import vision
from planner.scene import CircleRecord, Scene, SceneObject
from vision.picture_error import PictureError

Colour = tuple[float, float, float]
WIDTH, HEIGHT, FINER = 240, 180, 4
CENTRES = ((50.3, 60.2), (170.6, 50.9), (110.1, 130.4))
RADIUS = 22.0
PAIRS: dict[str, tuple[Colour, Colour]] = {
    "red on green": ((0, 0, 200), (0, 102, 0)),
    "green on grey": ((60, 160, 60), (116, 116, 116)),
    "blue on brown": ((220, 40, 40), (30, 74, 92)),
    "yellow on white": ((30, 215, 235), (225, 225, 225)),
    "cyan on pink": ((200, 180, 60), (180, 140, 190)),
}


def _cover() -> NDArray[np.float64]:
    """Share of each pixel that is covered by the discs, blurred as a lens does."""
    fine = np.zeros((HEIGHT * FINER, WIDTH * FINER))
    ys, xs = np.mgrid[0 : HEIGHT * FINER, 0 : WIDTH * FINER]
    for x, y in CENTRES:
        at_x, at_y = (x + 0.5) * FINER - 0.5, (y + 0.5) * FINER - 0.5
        fine[np.hypot(xs - at_x, ys - at_y) <= RADIUS * FINER] = 1.0
    coarse = fine.reshape(HEIGHT, FINER, WIDTH, FINER).mean(axis=(1, 3))
    return np.asarray(cv2.GaussianBlur(coarse, (0, 0), 0.6))


def _drawn(obstacle: Colour, floor: Colour, noise: float, seed: int = 1) -> NDArray[np.uint8]:
    cover = _cover()[:, :, None]
    values = cover * np.array(obstacle, float) + (1.0 - cover) * np.array(floor, float)
    values = values + np.random.default_rng(seed).normal(0.0, noise, values.shape)
    return np.asarray(np.clip(np.rint(values), 0, 255), dtype=np.uint8)


def _left(o: SceneObject) -> float:
    (record,) = o.records
    assert isinstance(record, CircleRecord)
    return record.center[0]


def _check(scene: Scene, noise: float = 0.0) -> None:
    assert len(scene.objects) == len(CENTRES)
    for o, truth in zip(sorted(scene.objects, key=_left), sorted(CENTRES), strict=True):
        (record,) = o.records
        assert isinstance(record, CircleRecord)
        assert record.center == pytest.approx(truth, abs=0.1)
        assert record.radius == pytest.approx(RADIUS, abs=0.15 + 0.02 * noise)


@pytest.mark.parametrize("noise", [0.0, 3.0, 8.0])
@pytest.mark.parametrize("pair", list(PAIRS))
def test_colours_are_seen_where_grey_tells_nothing(pair: str, noise: float) -> None:
    obstacle, floor = PAIRS[pair]
    scene = vision.extract(_drawn(obstacle, floor, noise))
    _check(scene, noise)
    if pair == "red on green":
        assert scene.binarisation is not None
        assert scene.binarisation.method == "colour"
    _check(vision.extract(_drawn(floor, obstacle, noise), polarity="light"), noise)


def test_every_block_on_a_white_floor_is_seen_not_only_the_dark_ones() -> None:
    picture = np.full((HEIGHT, WIDTH, 3), 225, np.uint8)
    blocks = [(40, 40, 200), (60, 150, 50), (190, 80, 30), (30, 30, 30), (20, 140, 240)]
    for number, colour in enumerate([*blocks, (30, 215, 235)]):
        x, y = 20 + number % 3 * 75, 20 + number // 3 * 80
        picture[y : y + 50, x : x + 45] = colour
    assert len(vision.extract(picture).objects) == 6


@pytest.mark.parametrize("floor", [(225, 225, 225), (60, 160, 60), (40, 60, 200)])
def test_a_shadow_on_a_coloured_floor_has_no_colour_of_its_own(floor: Colour) -> None:
    picture = _drawn((20, 20, 20), floor, 2.0).astype(float)
    shade = 1.0 - 0.3 / (1.0 + np.exp((np.arange(WIDTH) - 0.6 * WIDTH) / 15.0))
    shaded = np.clip(np.rint(picture * shade[None, :, None]), 0, 255).astype(np.uint8)
    scene = vision.extract(shaded)
    assert len(scene.objects) == len(CENTRES)
    assert scene.binarisation is not None
    assert scene.binarisation.method != "colour"


@pytest.mark.parametrize("quality", [50, 90])
def test_a_grey_scene_in_colours_is_that_of_its_grey(quality: int) -> None:
    """Noise of each channel, and the colours that JPEG lets run, are none of the obstacles'."""
    picture = _drawn((40, 40, 40), (215, 215, 215), 10.0)
    ok, packed = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, quality])
    assert ok
    picture = np.asarray(cv2.imdecode(packed, cv2.IMREAD_COLOR), dtype=np.uint8)
    coloured = vision.extract(picture)
    grey = vision.extract(cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY))
    assert coloured.objects == grey.objects
    assert coloured.binarisation == grey.binarisation


def test_colours_count_in_16_bits_and_beside_transparency_and_not_where_ignored() -> None:
    picture = _drawn(*PAIRS["red on green"], 0.0)
    _check(vision.extract(picture.astype(np.uint16) * 200))
    alpha = np.full((HEIGHT, WIDTH, 1), 255, np.uint8)
    _check(vision.extract(np.concatenate([picture, alpha], axis=2)))
    discs = [(x, y, RADIUS + 6.0) for x, y in CENTRES[:2]]
    assert len(vision.extract(picture, ignore=discs).objects) == 1


def test_a_level_that_is_given_is_one_of_grey() -> None:
    picture = _drawn(*PAIRS["yellow on white"], 0.0)
    scene = vision.extract(picture, method="fixed", threshold=215.0)
    assert scene.binarisation is not None
    assert scene.binarisation.method == "fixed"
    with pytest.raises(PictureError, match="no free space"):
        vision.extract(picture, method="fixed", threshold=255.0)
