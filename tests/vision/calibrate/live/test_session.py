"""A live calibration against a simulated board: it asks, takes, refuses, and knows when to end."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tests.support.runs.held_board import (
    CHARUCO,
    CHESSBOARD,
    FOCAL_PX,
    VirtualTime,
    held_board,
)
from vision.calibrate.board import BoardSpec, BoardView, find_board
from vision.calibrate.lens import estimate_lens
from vision.calibrate.live.following import BoardFollower
from vision.calibrate.live.guide import is_new
from vision.calibrate.live.session import FEWEST_VIEWS, LiveSession, LiveState
from vision.calibration.calibration import CalibrationError
from vision.camera.camera import Frame

FRAMES_AT_MOST = 900


def held(spec: BoardSpec, limit_px: float, seed: int = 0) -> tuple[LiveSession, list[LiveState]]:
    """A session that goes on until it is done, and every state of it."""
    session, time = LiveSession(spec, limit_px), VirtualTime()
    camera = held_board(spec, session, time, seed)
    camera.open()
    states: list[LiveState] = []
    while len(states) < FRAMES_AT_MOST and not (states and states[-1].done):
        frame = camera.read(1.0)
        assert frame is not None
        states.append(session.look(frame))
    return session, states


@pytest.fixture(scope="module")
def charuco() -> tuple[LiveSession, list[LiveState]]:
    return held(CHARUCO, 0.5)


def test_it_takes_views_until_the_lens_is_known(
    charuco: tuple[LiveSession, list[LiveState]],
) -> None:
    session, states = charuco
    last = states[-1]
    assert last.done
    assert last.cells.done.all()
    assert last.cells.worst_px <= 0.5
    assert last.wanted is None
    assert FEWEST_VIEWS <= last.count == len(session.views) <= 30
    lens = estimate_lens(session.views)
    assert lens.camera_matrix[0, 0] == pytest.approx(FOCAL_PX, rel=0.005)


def test_a_chessboard_serves_as_well() -> None:
    session, states = held(CHESSBOARD, 0.3)
    assert states[-1].done
    lens = estimate_lens(session.views)
    assert lens.camera_matrix[0, 0] == pytest.approx(FOCAL_PX, rel=0.005)


def test_views_are_of_a_board_at_rest_and_each_is_new(
    charuco: tuple[LiveSession, list[LiveState]],
) -> None:
    session, states = charuco
    assert all(state.still == 1.0 for state in states if state.taken)
    assert all(
        later.count - earlier.count == later.taken for earlier, later in itertools.pairwise(states)
    )
    for i, view in enumerate(session.views):
        assert is_new(view, session.views[:i])


def test_what_is_wanted_is_in_the_picture_and_new(
    charuco: tuple[LiveSession, list[LiveState]],
) -> None:
    session, states = charuco
    for state in states:
        if state.wanted is None:
            continue
        assert (state.wanted.outline_px > 0.0).all()
        assert (state.wanted.outline_px < np.array(state.size)).all()
        assert state.wanted.sentence.startswith("hold the board ")
        assert is_new(state.wanted.pose.view, session.views[: state.count])


def test_following_asks_for_less_than_wandering(
    charuco: tuple[LiveSession, list[LiveState]],
) -> None:
    """What is asked for is worth asking for: a board held anywhere knows less by as many views."""
    _, states = charuco
    session, time = LiveSession(CHARUCO, 0.01), VirtualTime()
    camera = held_board(CHARUCO, None, time)
    camera.open()
    last = None
    while last is None or last.count < states[-1].count:
        frame = camera.read(1.0)
        assert frame is not None
        last = session.look(frame)
    assert last.cells.worst_px > 1.2 * states[-1].cells.worst_px


def test_a_board_that_was_followed_is_where_it_is_found() -> None:
    time = VirtualTime()
    camera = held_board(CHARUCO, None, time)
    camera.open()
    follower, compared = BoardFollower(CHARUCO), 0
    for _ in range(40):
        frame = camera.read(1.0)
        assert frame is not None
        followed = follower.look(frame.image, "a")
        found = find_board(frame.image, CHARUCO, "b")
        if isinstance(followed, BoardView) and isinstance(found, BoardView):
            places = {
                tuple(p): c for p, c in zip(found.points_m.round(6), found.corners_px, strict=True)
            }
            pairs = [
                (c, places[tuple(p)])
                for p, c in zip(followed.points_m.round(6), followed.corners_px, strict=True)
                if tuple(p) in places
            ]
            apart = [float(np.linalg.norm(a - b)) for a, b in pairs]
            assert np.median(apart) < 0.1
            compared += 1
    assert compared > 25


def test_a_view_that_does_not_fit_is_doubted_with_a_sentence(
    charuco: tuple[LiveSession, list[LiveState]],
) -> None:
    session, _ = charuco
    view = session.views[-1]
    assert session._doubt(view) == ""
    bent = view.corners_px + 4.0 * np.sin(view.corners_px[:, ::-1] / 30.0)
    assert "px rms from the views before" in session._doubt(replace(view, corners_px=bent))


def test_another_size_of_picture_and_a_limit_of_nothing_are_errors() -> None:
    session = LiveSession(CHARUCO)
    session.look(Frame(np.zeros((480, 640), np.uint8), 0.0, 0, "c"))
    with pytest.raises(CalibrationError, match="a picture of 320x240 pixels where those before"):
        session.look(Frame(np.zeros((240, 320), np.uint8), 0.1, 1, "c"))
    with pytest.raises(CalibrationError, match="limit = 0"):
        LiveSession(CHARUCO, 0.0)


def test_nothing_but_floor_says_that_no_board_is_seen() -> None:
    session = LiveSession(CHARUCO)
    state = session.look(Frame(np.full((480, 640), 128, np.uint8), 0.0, 0, "c"))
    assert state.view is None
    assert "no ChArUco board" in state.remark
    assert not state.cells.seen.any()
    assert np.isinf(state.cells.worst_px)
    assert state.wanted is not None
