"""Thin walls, lattices, letters and cut corners in black and white: records cover their pixels."""

from __future__ import annotations

import math

import cv2
import numpy as np
import pytest

from planner.scene import CircleRecord, PolygonRecord, Scene, Segment, object_records
from tests.support.drawn.render import outline_points
from vision import PictureError, extract

Mask = np.ndarray
LEAST_AREA = 400


def extracted(mask: Mask) -> Scene:
    return extract(np.where(mask, 0, 255).astype(np.uint8))


def enclosed(outline: np.ndarray, size: tuple[int, int]) -> Mask:
    """The pixels (h, w) whose centres a closed polyline encloses, even-odd."""
    width, height = size
    inside = np.zeros((height, width), bool)
    for (x0, y0), (x1, y1) in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        low, high = (max(0, math.ceil(y)) for y in sorted((y0, y1)))
        ys = np.arange(low, min(high, height))
        xs = x0 + (ys - y0) * (x1 - x0) / (y1 - y0) if len(ys) else ys
        inside[ys] ^= np.arange(width) > np.asarray(xs)[:, None]
    return inside


def drawn_again(scene: Scene, size: tuple[int, int]) -> list[Mask]:
    """The pixels of every object, (h, w) each: those whose centres its outlines enclose."""
    drawn = []
    for obj in scene.objects:
        inside = np.zeros((size[1], size[0]), bool)
        for record in object_records(obj):
            if isinstance(record, PolygonRecord | CircleRecord):
                inside ^= enclosed(outline_points(record, 0.01), size)
        drawn.append(inside)
    return drawn


def farthest(a: Mask, b: Mask) -> float:
    """The symmetric Hausdorff distance of two masks, in pixels."""
    away = [
        cv2.distanceTransform((~m).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        for m in (a, b)
    ]
    return float(max(away[0][b].max(), away[1][a].max()))


def assert_covered(mask: Mask) -> None:
    """Every object of at least LEAST_AREA pixels is drawn again to 0.995 and one pixel."""
    count, labels, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    again = drawn_again(extracted(mask), (mask.shape[1], mask.shape[0]))
    assert len(again) == count - 1
    for label in range(1, count):
        if stats[label, cv2.CC_STAT_AREA] < LEAST_AREA:
            continue
        truth = labels == label
        drawn = max(again, key=lambda m: int((m & truth).sum()))
        overlap = (truth & drawn).sum() / (truth | drawn).sum()
        assert overlap >= 0.995, f"{truth.sum()} px: {overlap:.4f}"
        assert farthest(truth, drawn) <= 1.0 + 1e-6, f"{truth.sum()} px"


def walls(seed: int) -> Mask:
    """Walls of 1 to 3 px on a grid, each with a gap that leaves square ends."""
    rng = np.random.default_rng([47, seed])
    mask = np.zeros((240, 320), bool)
    for upright in (False, True):
        across, along = (320, 240) if upright else (240, 320)
        for at in range(20, across - 10, 40):
            width = int(rng.integers(1, 4))
            lane = np.ones(along, bool)
            for _ in range(2):
                begin = int(rng.integers(0, along - 20))
                lane[begin : begin + int(rng.integers(8, 18))] = False
            if upright:
                mask[lane, at : at + width] = True
            else:
                mask[at : at + width, lane] = True
    return mask


def test_a_wall_of_three_pixels_ends_square_and_where_it_ends() -> None:
    """Its lattice once let it become a spike: there were many pixels to lose, none its own."""
    mask = np.zeros((240, 320), bool)
    for at in range(40, 320, 40):
        mask[:, at - 1 : at + 1] = True
    for at in range(40, 240, 40):
        mask[at - 1 : at + 1, :] = True
    mask[80:97, 58:61] = True
    mask[79:82, 40:80] = True
    assert_covered(mask)


@pytest.mark.parametrize("seed", range(6))
def test_thin_walls_with_gaps_are_covered(seed: int) -> None:
    assert_covered(walls(seed))


@pytest.mark.parametrize("seed", range(4))
def test_a_thin_ring_with_pieces_chopped_off_is_covered(seed: int) -> None:
    rng = np.random.default_rng([53, seed])
    picture = np.zeros((200, 260), np.uint8)
    box = np.array([30, 30]), np.array([230, 165])
    cv2.rectangle(picture, box[0].tolist(), box[1].tolist(), 1, 2)
    for _ in range(8):
        x, y = (int(v) for v in rng.integers([25, 25], [235, 170]))
        cv2.circle(picture, (x, y), int(rng.integers(2, 9)), int(rng.integers(0, 2)), -1)
    assert_covered(picture > 0)


@pytest.mark.parametrize("font", range(5))
def test_letters_are_covered(font: int) -> None:
    for code in range(48, 123, 3):
        picture = np.zeros((120, 120), np.uint8)
        scale, thickness = 2.0 + 0.25 * (code % 5), 6 + code % 7
        cv2.putText(picture, chr(code), (30, 90), font, scale, 1, thickness)
        assert_covered(picture > 0)


@pytest.mark.parametrize("seed", range(12))
def test_blobs_are_covered(seed: int) -> None:
    rng = np.random.default_rng([59, seed])
    field = cv2.GaussianBlur(rng.standard_normal((200, 200)), (0, 0), rng.uniform(6, 15))
    assert_covered(field > np.quantile(field, 0.8))


def test_lines_with_round_caps_and_chamfered_bars_are_covered() -> None:
    for seed in range(30):
        rng = np.random.default_rng([61, seed])
        picture = np.zeros((200, 200), np.uint8)
        ends = rng.integers(20, 180, (3, 2)).tolist()
        cv2.polylines(picture, [np.array(ends)], seed % 2 == 0, 1, int(rng.integers(5, 20)))
        assert_covered(picture > 0)
        width, height, cut = (int(v) for v in rng.integers([12, 40, 1], [30, 120, 4]))
        chamfered = np.zeros((200, 200), np.uint8)
        right, bottom = 40 + width, 40 + height
        corners = [(40 + cut, 40), (right - cut, 40), (right, 40 + cut), (right, bottom - cut)]
        corners += [(right - cut, bottom), (40 + cut, bottom), (40, bottom - cut), (40, 40 + cut)]
        cv2.fillPoly(chamfered, [np.array(corners)], 1)
        assert_covered(chamfered > 0)


@pytest.mark.parametrize("gap", [2, 3, 4])
def test_points_beside_a_thin_wall_are_not_drawn_across_it(gap: int) -> None:
    """A wall of 3 px, or a gap of 3 px: the outermost sample lies beyond, and must not count."""
    mask = np.zeros((80, 120), bool)
    mask[20:40, 20:100] = True
    mask[40 + gap : 60, 20:100] = True
    for black, bounds in ((mask, (19.5, 39.5)), (~mask, (39.5, 39.5 + gap))):
        ys = sorted(
            {
                round(edge.start[1], 6)
                for obj in extracted(black).objects
                for record in object_records(obj)
                for edge in getattr(record, "edges", ())
                if isinstance(edge, Segment) and abs(edge.end[0] - edge.start[0]) > 20
            }
        )
        assert all(any(math.isclose(y, b, abs_tol=1e-6) for y in ys) for b in bounds), ys


def test_residuals_are_those_of_all_cracks() -> None:
    """A side put half a pixel off once said 0; where nothing is off there is nothing to say."""
    mask = np.zeros((140, 60), bool)
    mask[20:120, 20:30] = True
    (whole,) = extracted(mask).objects
    assert isinstance(whole.records[0], PolygonRecord)
    assert whole.records[0].residual_px < 1e-6
    mask[[20, 20, 119, 119], [20, 29, 20, 29]] = False
    (cut,) = extracted(mask).objects
    assert isinstance(cut.records[0], PolygonRecord)
    sides = [e for e in cut.records[0].edges if abs(e.end[1] - e.start[1]) > 50.0]
    off = max(min(abs(e.start[0] - x) for x in (19.5, 29.5)) for e in sides)
    assert cut.records[0].residual_px > 0.1 or off < 0.1


def test_a_picture_may_be_plain_sequences() -> None:
    picture = np.full((40, 60), 255, np.uint8)
    picture[10:20, 15:35] = 0
    deep = picture.astype(np.uint16) * 257
    coloured = np.repeat(picture[:, :, None], 3, axis=2)
    for given in (picture, deep, coloured):
        assert extract(given.tolist()).objects == extract(picture).objects


@pytest.mark.parametrize(
    ("given", "why"),
    [
        ([[0.5, 1.0]], "whole numbers"),
        ([[0, 1], [2]], "equally long"),
        ([[-1, 3]], "-1 .. 3"),
        ([[0, 65536]], "0 .. 65536"),
        ([], "shape"),
        ("picture.png", "str"),
        (None, "NoneType"),
    ],
)
def test_what_is_no_picture_is_refused(given: object, why: str) -> None:
    with pytest.raises(PictureError, match=why):
        extract(given)  # type: ignore[arg-type]
