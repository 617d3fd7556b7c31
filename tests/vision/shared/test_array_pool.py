"""Memory that pictures share: what was made in it stays right, whoever comes next."""

from __future__ import annotations

from threading import Thread

import numpy as np

from tests.support.drawn.render import draw, polygon
from vision import extract
from vision.binarise.binarise import binarise
from vision.borders.contours import follow_borders
from vision.shared.array_pool import ArrayPool


def test_a_smaller_picture_after_a_larger_one_is_extracted_as_if_it_were_the_first() -> None:
    large = draw([polygon(np.array([(20, 20), (180, 30), (170, 140), (30, 130)]))], (200, 160))
    small = draw([polygon(np.array([(5, 5), (25, 6), (24, 20)]))], (31, 27))
    alone = extract(small).objects
    extract(255 - large, polarity="light")
    extract(large)
    assert extract(small).objects == alone


def test_following_borders_leaves_the_mask_as_it_was() -> None:
    rng = np.random.default_rng(3)
    picture = np.where(rng.random((90, 70)) < 0.4, 0, 255).astype(np.uint8)
    mask = binarise(picture).mask
    before = mask.copy()
    first = follow_borders(mask)
    np.testing.assert_array_equal(mask, before)
    np.testing.assert_array_equal(follow_borders(mask).x, first.x)


def test_borders_that_need_more_space_than_is_likely_are_followed_whole() -> None:
    # a chessboard of single pixels: two cracks a pixel of the picture
    picture = np.where(np.indices((300, 300)).sum(axis=0) % 2, 255, 0).astype(np.uint8)
    picture[0] = picture[-1] = picture[:, 0] = picture[:, -1] = 255
    pool = ArrayPool()
    borders = follow_borders(binarise(picture).mask, pool)
    inside = int(np.count_nonzero(picture == 0))
    assert int(np.diff(borders.starts).sum()) == 4 * inside


def test_every_thread_has_its_own_pool() -> None:
    pool = ArrayPool()
    mine = pool.take("mask", 8, np.uint8)
    mine[:] = 1
    others: list[np.ndarray] = []
    thread = Thread(target=lambda: others.append(pool.take("mask", 8, np.uint8)))
    thread.start()
    thread.join()
    others[0][:] = 2
    assert (mine == 1).all()
    assert not np.shares_memory(mine, others[0])
    assert np.shares_memory(mine, pool.take("mask", 4, np.int16))
