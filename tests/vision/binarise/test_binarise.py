"""Binarisation: the right method is chosen, said why, and the mask is right."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from planner.scene import CircleRecord
from tests.support.drawn.render import coverage, draw, outline_points, polygon, ramp
from vision.binarise.binarise import binarise
from vision.binarise.binarise_kernels import noise_sigma
from vision.binarise.grey_picture import NO_SMOOTHING, GreyPicture, as_grey
from vision.binarise.light_surface import light_surface
from vision.picture_error import PictureError
from vision.pipeline import extract

SIZE = (320, 240)


def discs(share: float, count: int = 4) -> list[CircleRecord]:
    radius = math.sqrt(SIZE[0] * SIZE[1] * share / count / math.pi)
    return [
        CircleRecord(((i % 2 + 0.5) * SIZE[0] / 2, (i // 2 + 0.5) * SIZE[1] / 2), radius)
        for i in range(count)
    ]


def truth(records: list[CircleRecord]) -> np.ndarray:
    return sum(coverage([outline_points(r)], SIZE) for r in records) >= 0.5


def overlap(a: np.ndarray, b: np.ndarray) -> float:
    return float((a & b).sum() / (a | b).sum())


@pytest.mark.parametrize("share", [0.002, 0.05, 0.3])
@pytest.mark.parametrize("noise", [0.0, 10.0, 20.0])
def test_even_light_takes_one_level_at_any_dark_area_and_noise(share: float, noise: float) -> None:
    records = discs(share)
    picture = draw(records, SIZE, noise=noise, rng=np.random.default_rng(1))
    binary = binarise(picture)
    assert binary.how.method == "otsu"
    assert "even light" in binary.how.reason
    assert overlap(binary.inside > 0, truth(records)) > (0.8 if share < 0.01 else 0.97)
    assert cv2.connectedComponents(binary.inside, connectivity=8)[0] == 5


@pytest.mark.parametrize("fall", [0.5, 0.8])
@pytest.mark.parametrize("angle", [0.0, 0.9])
@pytest.mark.parametrize("noise", [0.0, 4.0])
def test_a_ramp_of_light_is_divided_out(fall: float, angle: float, noise: float) -> None:
    records = discs(0.1)
    picture = draw(
        records, SIZE, lit=ramp(SIZE, fall, angle), noise=noise, rng=np.random.default_rng(2)
    )
    binary = binarise(picture)
    assert binary.how.method == "background"
    assert overlap(binary.inside > 0, truth(records)) > 0.95


def test_the_light_surface_follows_the_light_and_not_the_obstacles() -> None:
    lit = ramp(SIZE, 0.6, 0.5)
    surface = light_surface(draw(discs(0.3), SIZE, lit=lit))
    assert np.abs(surface / (215.0 * lit) - 1.0).max() < 0.06


def test_most_of_the_picture_may_be_obstacle() -> None:
    block = polygon([(-5, -5), (325, -5), (325, 150), (-5, 150)])
    picture = draw([block], SIZE, noise=5.0, rng=np.random.default_rng(3))
    assert abs(binarise(picture).inside.mean() - 150.5 / 240.0) < 0.01


@pytest.mark.parametrize("method", ["otsu", "adaptive", "background"])
def test_every_method_can_be_asked_for(method: str) -> None:
    records = discs(0.05)
    binary = binarise(draw(records, SIZE), method=method)
    assert binary.how.method == method
    assert overlap(binary.inside > 0, truth(records)) > 0.9


def test_a_fixed_level_is_exact() -> None:
    picture = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert int(binarise(picture, threshold=100).inside.sum()) == 100
    light = binarise(picture, threshold=100, polarity="light")
    assert int(light.inside.sum()) == 156


def test_polarity_auto_takes_the_rarer_side_and_says_so() -> None:
    picture = draw(discs(0.1), SIZE)
    for shown, side in ((picture, "dark"), (255 - picture, "light")):
        binary = binarise(shown, polarity="auto")
        assert binary.how.polarity == side
        assert f"obstacles are {side}" in binary.how.reason
        assert overlap(binary.inside > 0, truth(discs(0.1))) > 0.97


@pytest.mark.parametrize("sigma", [0.0, 2.0, 10.0, 20.0])
def test_noise_is_measured_past_edges_and_ramps(sigma: float) -> None:
    rng = np.random.default_rng(4)
    clean = draw(discs(0.2), SIZE, lit=ramp(SIZE, 0.3)).astype(float)
    noisy = np.clip(np.rint(clean + rng.normal(0, sigma, clean.shape)), 0, 255).astype(np.uint8)
    assert abs(noise_sigma(noisy) - sigma) < 0.1 * sigma + 0.6


def test_a_transparent_background_is_white() -> None:
    picture = np.zeros((40, 40, 4), np.uint8)
    picture[10:20, 10:20, 3] = 255
    assert int(binarise(picture).inside.sum()) == 100


def test_16_bits_are_scaled_by_the_brightest_pixel() -> None:
    deep = np.array([[0, 1023], [4092, 2046]], np.uint16)
    assert np.allclose(as_grey(deep), [[0.0, 63.75], [255.0, 127.5]])


def test_rare_dark_pixels_are_seen_though_no_sample_shows_them() -> None:
    picture = np.full((900, 1200), 250, np.uint8)
    picture[501, 701] = 3
    assert int(binarise(picture).inside.sum()) == 1


def test_a_picture_without_free_space_is_refused() -> None:
    with pytest.raises(PictureError, match="no free space"):
        binarise(np.full((30, 40), 3, np.uint8))
    with pytest.raises(PictureError, match="no free space"):
        binarise(np.full((30, 40), 250, np.uint8), polarity="light")


@pytest.mark.parametrize("fall", [0.5, 0.7, 0.8])
@pytest.mark.parametrize("toward", [(1, 0), (0, 1), (0.5, 0.5)])
@pytest.mark.parametrize("side", ["dark", "light"])
def test_a_ramp_of_light_leaves_obstacles_of_either_side_what_they_are(fall, toward, side):
    """Light multiplies what the camera sees: light obstacles fade most, dark ground least."""
    there = np.zeros((480, 640), np.uint8)
    for x, y, w, h in ((50, 80, 100, 60), (260, 60, 120, 30), (260, 310, 80, 80)):
        there[y : y + h, x : x + w] = 1
    for x, y, r in ((500, 120, 45), (120, 350, 8), (520, 381, 70)):
        cv2.circle(there, (x, y), r, 1, -1)
    y, x = np.mgrid[:480, :640]
    light = 1.0 - fall * (toward[0] * x / 640 + toward[1] * y / 480)
    albedo = np.where(there == 1, 40, 220) if side == "dark" else np.where(there == 1, 220, 40)
    noise = 3.0 * np.random.default_rng(3).standard_normal(there.shape)
    picture = np.clip(np.rint(albedo * light + noise), 0, 255).astype(np.uint8)
    inside = binarise(picture, polarity=side).inside.astype(bool)
    wrong = np.count_nonzero(inside != (there == 1))
    assert wrong <= 0.002 * np.count_nonzero(there)


def walls(width: float, blur: float, noise: float = 0.0) -> np.ndarray:
    """A picture of four hollow frames with walls so wide, dark 40 on 215."""
    frames = []
    for x, y, angle in ((75, 60, 0.09), (240, 60, 0.4), (75, 175, 0.8), (240, 175, 1.2)):
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        for half in (45.0, 45.0 - width):
            corners = half * np.array([(-1, -1), (1, -1), (1, 0.8), (-1, 0.8)])
            frames.append(corners @ turn.T + (x, y))
    grey = 215.0 - 175.0 * coverage(frames, SIZE)
    grey = cv2.GaussianBlur(grey, (0, 0), blur) if blur > 0.0 else grey
    grey += np.random.default_rng(5).normal(0.0, noise, grey.shape)
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize(
    ("width", "blur"), [(3, 0.0), (3, 0.5), (3, 0.7), (4, 0.7), (4, 1.0), (6, 1.5), (10, 1.5)]
)
def test_walls_as_thin_as_their_edges_do_not_pull_the_level_up(width, blur, side) -> None:
    picture = walls(width, blur)
    binary = binarise(picture if side == "dark" else 255 - picture, polarity=side)
    assert abs(binary.level - 127.5) < 2.0
    assert abs(binary.contrast - 175.0) < 4.0


@pytest.mark.parametrize("noise", [5.0, 10.0])
def test_nor_do_they_in_noise(noise: float) -> None:
    assert abs(binarise(walls(4, 0.7, noise)).level - 127.5) < 4.0


def test_thin_gaps_do_not_pull_the_level_down() -> None:
    binary = binarise(255 - walls(4, 0.7))
    assert abs(binary.level - 127.5) < 1.5


LARGE = (640, 480)
SIX = [
    *(CircleRecord(at, r) for at, r in (((100, 100), 40), ((540, 100), 30), ((320, 360), 50))),
    polygon([(275, 70), (365, 60), (370, 125), (280, 135)]),
    polygon([(80, 310), (130, 320), (120, 410), (70, 400)]),
    polygon([(500, 320), (580, 325), (575, 400), (495, 395)]),
]


def shadow(share: float, wide: float, at: float = 430.0) -> np.ndarray:
    """Light that falls off softly beyond a column of a large picture."""
    x = np.arange(LARGE[0])[None].repeat(LARGE[1], axis=0)
    return 1.0 - share / (1.0 + np.exp(-(x - at) / wide))


def objects_in(picture: np.ndarray, **how: object) -> int:
    return cv2.connectedComponents(binarise(picture, **how).inside, connectivity=8)[0] - 1


@pytest.mark.parametrize("share", [0.1, 0.2, 0.3, 0.4])
@pytest.mark.parametrize(("wide", "at"), [(5, 200), (15, 430), (80, 430)])
@pytest.mark.parametrize("noise", [0.0, 5.0])
def test_a_soft_shadow_is_no_obstacle(share: float, wide: float, at: float, noise: float) -> None:
    lit = shadow(share, wide, at)
    picture = draw(SIX, LARGE, lit=lit, noise=noise, rng=np.random.default_rng(6))
    assert objects_in(picture) == 6


@pytest.mark.parametrize("share", [0.5, 0.6])
@pytest.mark.parametrize(("wide", "at"), [(5, 200), (40, 430), (80, 430)])
@pytest.mark.parametrize("noise", [0.0, 5.0])
@pytest.mark.parametrize("side", ["dark", "light"])
def test_obstacles_in_a_deep_shadow_are_counted(share, wide, at, noise, side) -> None:
    dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
    lit = shadow(share, wide, at)
    rng = np.random.default_rng(6)
    picture = draw(SIX, LARGE, dark=dark, light=light, lit=lit, noise=noise, rng=rng)
    assert objects_in(picture, polarity=side) == 6


@pytest.mark.parametrize("noise", [0.0, 2.0, 5.0, 10.0, 20.0])
@pytest.mark.parametrize("depth", [0.1, 0.14])
def test_the_joints_of_a_floor_are_no_obstacles(depth: float, noise: float) -> None:
    lit = np.ones((LARGE[1], LARGE[0]))
    for k in range(3):
        lit[17 + k :: 40] = 1.0 - depth
        lit[:, 23 + k :: 40] = 1.0 - depth
    lit = cv2.GaussianBlur(lit, (0, 0), 0.7)
    picture = draw(SIX, LARGE, lit=lit, noise=noise, rng=np.random.default_rng(10))
    assert objects_in(picture) == 6


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("side", ["dark", "light"])
def test_few_obstacles_under_a_steep_ramp_in_strong_noise_are_counted(seed: int, side: str) -> None:
    dark, light = (40.0, 215.0) if side == "dark" else (215.0, 40.0)
    rng = np.random.default_rng(seed)
    records = [
        CircleRecord((80.0 + 160 * i, 80.0 + 160 * j), rng.uniform(6.0, 7.5))
        for i in range(4)
        for j in range(3)
    ]
    lit = ramp(LARGE, 0.8, 0.9 * seed)
    picture = draw(records, LARGE, dark=dark, light=light, lit=lit, noise=20.0, rng=rng)
    assert objects_in(picture, polarity=side) == 12


@pytest.mark.parametrize("seed", range(6))
def test_light_objects_under_a_spotlight_are_counted(seed: int) -> None:
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: LARGE[1], : LARGE[0]]
    away = (x - rng.uniform(100, 540)) ** 2 + (y - rng.uniform(100, 380)) ** 2
    lit = 1.0 - 0.7 * (1.0 - np.exp(-away / 2.0 / 250.0**2))
    small = [
        CircleRecord((60.0 + 85.0 * i, rng.uniform(40, 440)), rng.uniform(7, 14)) for i in range(7)
    ]
    picture = draw(small, LARGE, dark=215.0, light=40.0, lit=lit)
    assert objects_in(picture, polarity="light") == 7


@pytest.mark.parametrize("noise", [0.0, 5.0, 20.0])
@pytest.mark.parametrize("lit", [ramp(LARGE, 0.3), ramp(LARGE, 0.8, 0.4), shadow(0.6, 20.0)])
def test_uneven_light_on_an_empty_arena_is_no_obstacle(lit: np.ndarray, noise: float) -> None:
    picture = draw([], LARGE, lit=lit, noise=noise, rng=np.random.default_rng(7))
    assert objects_in(picture) == 0


@pytest.mark.parametrize("share", [0.0005, 0.002])
@pytest.mark.parametrize("seed", range(3))
def test_few_dark_pixels_under_a_ramp_in_noise_are_all_that_is_seen(
    share: float, seed: int
) -> None:
    radius = math.sqrt(LARGE[0] * LARGE[1] * share / 4 / math.pi)
    records = [CircleRecord((x, y), radius) for x in (160.0, 480.0) for y in (120.0, 360.0)]
    lit = ramp(LARGE, 0.8, 0.7 * seed)
    picture = draw(records, LARGE, lit=lit, noise=20.0, rng=np.random.default_rng(seed))
    assert objects_in(picture) == 4


@pytest.mark.parametrize("side", ["dark", "light"])
@pytest.mark.parametrize("noise", [0.0, 3.0, 5.0, 10.0, 20.0])
def test_the_adaptive_level_knows_the_noise(noise: float, side: str) -> None:
    records = [CircleRecord((100 + 110 * i, 240), 10.0 + 2 * i) for i in range(5)]
    picture = draw(records, LARGE, noise=noise, rng=np.random.default_rng(9))
    shown = picture if side == "dark" else 255 - picture
    assert objects_in(shown, polarity=side, method="adaptive") == 5


def dots(radius: float, disc: bool) -> list[CircleRecord]:
    """Dots 26 px apart on a large picture, where there is a disc none on it."""
    rng = np.random.default_rng(5)
    places = [
        (16.0 + 26 * i + rng.uniform(-5, 5), 16.0 + 26 * j + rng.uniform(-5, 5))
        for i in range(24)
        for j in range(18)
    ]
    if not disc:
        return [CircleRecord(at, radius) for at in places]
    far = [CircleRecord(at, radius) for at in places if math.dist(at, (320, 240)) > 90.0]
    return [*far, CircleRecord((320.0, 240.0), 70.0)]


@pytest.mark.parametrize(
    ("radius", "noise", "disc"),
    [(0.8, 10.0, False), (1.2, 20.0, False), (1.5, 20.0, False), (1.2, 20.0, True), (2, 20, True)],
)
def test_dots_that_stand_out_of_the_noise_are_all_counted(radius, noise, disc) -> None:
    records = dots(radius, disc)
    rng = np.random.default_rng(6)
    picture = draw(records, LARGE, blur=0.5, noise=noise, rng=rng)
    assert len(extract(picture).objects) == len(records)


@pytest.mark.parametrize("side", ["dark", "light"])
def test_single_pixels_nine_sigmas_deep_are_obstacles_and_noise_is_not(side: str) -> None:
    rng = np.random.default_rng(7)
    grey = np.full((480, 640), 215.0)
    grey[20:120, 20:120] = 40.0
    grey[200::40, 200::40] = 40.0
    picture = np.clip(np.rint(grey + rng.normal(0.0, 19.0, grey.shape)), 0, 255).astype(np.uint8)
    shown = picture if side == "dark" else 255 - picture
    assert abs(len(extract(shown, polarity=side).objects) - (1 + 7 * 11)) <= 1


def test_no_noise_alone_is_a_dot() -> None:
    rng = np.random.default_rng(8)
    for _ in range(20):
        picture = draw([CircleRecord((320, 240), 60.0)], LARGE, noise=24.0, rng=rng)
        assert len(extract(picture).objects) == 1


def test_dots_beside_something_large_do_not_fray_its_edge() -> None:
    rng = np.random.default_rng(9)
    block = polygon([(80, 60), (560, 60), (560, 420), (80, 420)])
    picture = draw([block], LARGE, noise=20.0, rng=rng)
    inside = binarise(picture).inside
    assert cv2.connectedComponents(inside, connectivity=8)[0] == 2
    assert abs(int(inside.sum()) - 480 * 360) < 400


@pytest.mark.parametrize("sigma", [1.0, 5.0, 20.0])
def test_the_noise_is_the_same_however_the_picture_is_turned(sigma: float) -> None:
    rng = np.random.default_rng(8)
    clean = draw(SIX, LARGE, lit=ramp(LARGE, 0.3)).astype(float)[:, :-3]
    noisy = np.clip(np.rint(clean + rng.normal(0, sigma, clean.shape)), 0, 255).astype(np.uint8)
    there = noise_sigma(noisy)
    turned = (noisy[::-1], noisy[:, ::-1], noisy.T, np.rot90(noisy), np.rot90(noisy, 3))
    assert {noise_sigma(np.ascontiguousarray(one)) for one in turned} == {there}
    # a sample of the pixels has an error of its own
    assert abs(noise_sigma(np.roll(noisy, (3, -2), (0, 1))) - there) < 0.05 * there
    # whole grey values and the same in floating point are counted by other parts
    assert abs(noise_sigma(noisy.astype(np.float32)) - there) < 0.15 * there


@pytest.mark.parametrize("bound", [-1, 0, 1, 127, 254, 255])
def test_what_is_as_dark_as_the_bound_is_marked_and_the_margin_is_not(bound: int) -> None:
    grey = np.random.default_rng(3).integers(0, 256, (37, 29), np.uint8)
    grey[:2, :3] = [(0, 255, 127), (1, 254, 128)]
    mask = GreyPicture(grey).mask_below(bound + 1.0, NO_SMOOTHING, 1.0)
    wanted = np.zeros_like(mask)
    wanted[1:-1, 1:30] = grey.astype(int) <= bound
    assert np.array_equal(mask, wanted)
