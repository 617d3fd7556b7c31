"""Portable grey maps are read whole; a comment is never taken for a pixel, nor a pixel for one."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from planner.formats.pgm import parse_pgm
from planner.scene import SceneError


@given(
    arrays(np.uint16, array_shapes(min_dims=2, max_dims=2, max_side=5), elements=st.integers(0, 9)),
    st.integers(9, 65535),
    st.booleans(),
)
def test_pgm_is_read_in_text_and_binary_of_one_and_two_bytes(values, maximum, binary):
    height, width = values.shape
    head = f"P{5 if binary else 2} # size\n{width}\t{height}\n# most\n{maximum}\n".encode()
    if binary:
        body = values.astype(">u2" if maximum > 255 else np.uint8).tobytes()
    else:
        body = "\n".join(" ".join(map(str, row)) for row in values.tolist()).encode()
    np.testing.assert_array_equal(parse_pgm(head + body, "x"), values / maximum)


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"P5", "header"),
        (b"P6 1 1 255\n...", "header"),
        (b"P5 0 1 255\n", "must be > 0"),
        (b"P5 1 1 0\n\x00", "maximum"),
        (b"P5 1 1 70000\n\x00", "maximum"),
        (b"P5 99999 99999 255\n\x00", "cut short: 1 of"),
        (b"P2 2 1 9 1", "cut short: 1 of 2"),
        (b"P2 1 1 9 x", "not a whole number"),
        (b"P2 1 1 9 -1", "not a whole number"),
        (b"P2 1 1 9 10", "maximum is 9"),
        (b"P5 1 1 9\n\x0a", "maximum is 9"),
        (b"P5 1 1 9\x05", "without white space between its maximum and its pixels"),
        (b"P5 1 1 9#comment", "without white space"),
        (b"P5 1 1 9#comment\n", "cut short: 0 of 1"),
        (b"P5 2 1 99#comment\n#\n", "cut short: 0 of 2"),
    ],
)
def test_a_bad_pgm_is_refused(data, what):
    with pytest.raises(SceneError, match=r"^map\.pgm: ") as caught:
        parse_pgm(data, "map.pgm")
    assert what in str(caught.value)


@pytest.mark.parametrize("comments", [b"# one\n", b"# one\r", b"# one\n# two\n", b"#\n"])
@pytest.mark.parametrize("delimiter", [b"\n", b" ", b""])
@pytest.mark.parametrize("first", [0, 10, 255])
def test_a_comment_glued_to_the_maximum_of_a_pgm_shifts_no_pixel(comments, delimiter, first):
    values = np.array([[first, 1, 2], [3, 35, 10]], np.uint8)
    data = b"P5\n3 2\n255" + comments + delimiter + values.tobytes()
    np.testing.assert_array_equal(parse_pgm(data, "x"), values / 255)


def test_a_comment_glued_to_any_number_of_a_pgm_is_no_pixel():
    values = np.array([[7, 8], [9, 10]])
    for kind, body in ((b"P5", values.astype(np.uint8).tobytes()), (b"P2", b"7 8#x\n9 10")):
        data = kind + b"# made\n2#wide\n2#high\n10#most\n\n" + body
        np.testing.assert_array_equal(parse_pgm(data, "x"), values / 10)


def test_a_comment_after_white_space_behind_the_maximum_is_pixels():
    values = np.frombuffer(b"#\n", np.uint8).reshape(1, 2)
    np.testing.assert_array_equal(parse_pgm(b"P5 2 1 255\n#\n", "x"), values / 255)
