"""A live calibration: takes frames, returns what to show.

Rules
- A view is taken when the board is still in a new place and fits the earlier ones.
- The lens is then fitted with all five terms: undetermined ones show where views are missing.
- Enough: every cell is done, and the focal length is known to ``FOCAL_SHARE``.
- After three in a row that do not fit, the earlier ones may be wrong: all are judged together
  (`suspects`), and the smaller part goes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

from vision.calibrate.board import BoardSpec, BoardView, find_board
from vision.calibrate.covariance import (
    MOST_TERMS,
    KnownLens,
    known_lens,
    prior_normal,
    seen_through,
    supposed_lens,
)
from vision.calibrate.left_out import residuals_px, rms_px
from vision.calibrate.lens import estimate_for
from vision.calibrate.live.board_stillness import BoardStillness
from vision.calibrate.live.following import BoardFollower
from vision.calibrate.live.guide import Cells, HeldPose, Wanted, is_new, judge_cells, next_place
from vision.calibrate.suspects import bad_px, suspects
from vision.calibration.calibration import CalibrationError
from vision.camera.camera import Frame, Image

LIMIT_PX: Final = 0.3
"""Half a millimetre on the floor at 1.7 mm a pixel, at worst."""
FOCAL_SHARE: Final = 0.005
"""It moves a marker 0.1 m above the floor, seen 1 m off by a camera 2 m up, by 0.25 mm."""
FEWEST_VIEWS: Final = 6
MOST_VIEWS: Final = 60
"""More bring little: a bent board stays."""
_FITTED_FROM: Final = 3
_DOUBTS: Final = 3
_USABLE_FOCAL: Final = 0.2
"""Relative spread of the focal length from which a supposed lens guides as well."""


@dataclass(frozen=True, slots=True, eq=False)
class LiveState:
    """Everything to show of one frame.

    ``view`` is its board, or None with the reason in ``remark``; ``still`` 0 to 1; ``taken``: it
    became a view; ``count`` of views; ``cells`` and ``focal_share`` the precision; ``wanted`` the
    next pose; ``done``: enough.
    """

    size: tuple[int, int]
    view: BoardView | None
    still: float
    taken: bool
    count: int
    cells: Cells
    focal_share: float
    wanted: Wanted | None
    remark: str
    done: bool


class LiveSession:
    """Collector of views from frames; ``limit_px`` is the largest acceptable spread."""

    def __init__(self, spec: BoardSpec, limit_px: float = LIMIT_PX) -> None:
        if not (math.isfinite(limit_px) and limit_px > 0.0):
            raise CalibrationError(f"limit = {limit_px} px: must be > 0")
        self._spec, self._limit_px = spec, limit_px
        self._follower, self._stillness = BoardFollower(spec), BoardStillness()
        self._taken: list[tuple[BoardView, Image]] = []
        self._doubted: list[tuple[BoardView, Image]] = []
        self._size: tuple[int, int] | None = None
        self._lens: KnownLens | None = None
        self._cells: Cells | None = None
        self._wanted: Wanted | None = None
        self._number = 0
        self._is_charuco = spec.kind == "charuco"
        self._done = False

    @property
    def pictures(self) -> list[tuple[str, Image]]:
        """Names and pictures of the views taken."""
        return [(view.name, image) for view, image in self._taken]

    @property
    def views(self) -> list[BoardView]:
        """The views taken."""
        return [view for view, _ in self._taken]

    @property
    def wanted(self) -> Wanted | None:
        """The board's next pose; None before the first frame and when done."""
        return self._wanted

    def wanted_pose(self) -> HeldPose | None:
        """The same pose alone, for a simulated hand."""
        return None if self._wanted is None else self._wanted.pose

    def look(self, frame: Frame) -> LiveState:
        """Take the next frame; ``CalibrationError`` if its size differs from earlier frames."""
        if self._size is None:
            self._size = frame.size
            self._judge()
        if frame.size != self._size:
            raise CalibrationError(
                f"{frame.source}: a picture of {frame.size[0]}x{frame.size[1]} pixels where those "
                f"before had {self._size[0]}x{self._size[1]}"
            )
        found = self._follower.look(frame.image, "the picture")
        view = found if isinstance(found, BoardView) else None
        still = self._stillness.add(frame.captured_s, view)
        remark, taken = "" if view is not None else str(getattr(found, "reason", "")), False
        if view is not None and not is_new(view, self.views):
            remark = "there is a view from here already: move on"
        elif view is not None and still >= 1.0 and not self._done:
            taken, remark = self._take(frame, view)
            self._stillness.begin_again()
        return self._state(view, still, taken, remark)

    def _state(self, view: BoardView | None, still: float, taken: bool, remark: str) -> LiveState:
        assert self._size is not None
        assert self._cells is not None
        focal_share = math.inf if self._lens is None else self._lens.focal_share
        return LiveState(
            self._size, view, still, taken, len(self._taken), self._cells, focal_share,
            None if self._done else self._wanted, remark, self._done,
        )  # fmt: skip

    def _take(self, frame: Frame, followed: BoardView) -> tuple[bool, str]:
        """Take this frame as a view if it fits; return True if so, and the message."""
        self._number += 1
        name = f"view {self._number}"
        # more markers may be in sight than when the board was found
        again = find_board(frame.image, self._spec, name) if self._is_charuco else None
        view = again if isinstance(again, BoardView) else replace(followed, name=name)
        doubt = self._doubt(view)
        if doubt:
            self._doubted.append((view, frame.image))
            if len(self._doubted) < _DOUBTS:
                return False, f"{name}: not taken: {doubt}"
            return False, self._reconsider()
        self._doubted.clear()
        self._taken.append((view, frame.image))
        self._judge()
        return True, f"{name}: taken"

    def _doubt(self, view: BoardView) -> str:
        """Reason why a view does not fit the earlier ones; empty if it does."""
        if self._lens is None or len(self._taken) < FEWEST_VIEWS:
            return ""
        usual_px = math.sqrt(2.0) * self._lens.noise_px
        unknown_px = float(self._lens.sigma_px(view.corners_px).max())
        limit_px = bad_px(math.hypot(usual_px, unknown_px))
        off_px = rms_px(residuals_px(view, self._lens))
        if off_px <= limit_px:
            return ""
        return (
            f"{off_px:.2f} px rms from the views before, where at most {limit_px:.2f} px is usual: "
            "is the board flat, and the same?"
        )

    def _reconsider(self) -> str:
        everything = [*self._taken, *self._doubted]
        self._doubted.clear()
        views = [view for view, _ in everything]
        foreign = {one.index for one in suspects(views, estimate_for(views))}
        gone = [view.name for i, (view, _) in enumerate(everything) if i in foreign]
        self._taken = [pair for i, pair in enumerate(everything) if i not in foreign]
        self._judge()
        return f"views judged again; left out: {', '.join(gone) or 'none'}"

    def _judge(self) -> None:
        assert self._size is not None
        views = self.views
        self._lens = self._fit(views)
        self._cells = judge_cells(self._lens, views, self._size, self._limit_px)
        known = (
            self._lens is not None
            and len(views) >= FEWEST_VIEWS
            and self._lens.focal_share <= FOCAL_SHARE
            and bool(self._cells.done.all())
        )
        self._done = known or len(views) >= MOST_VIEWS
        guess = self._guess()
        self._wanted = None if self._done else next_place(guess, self._spec, views)

    def _fit(self, views: list[BoardView]) -> KnownLens | None:
        if len(views) < _FITTED_FROM:
            return None
        try:
            return known_lens(views, MOST_TERMS)
        except CalibrationError:
            return None

    def _guess(self) -> KnownLens:
        """The lens with an unknown lens's knowledge added, so that there is always a next pose."""
        assert self._size is not None
        lens = self._lens
        if lens is not None and lens.focal_share < _USABLE_FOCAL:
            normal = lens.normal + prior_normal(self._size, lens.noise_px)
            return replace(lens, normal=normal)
        lens = supposed_lens(self._size)
        return replace(lens, normal=lens.normal + sum(seen_through(lens, v) for v in self.views))
