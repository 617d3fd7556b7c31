"""A live calibration in sentences: the same for the terminal and the page."""

from __future__ import annotations

import math

from vision.calibrate.live.session import FOCAL_SHARE, LiveState


def figure_px(value: float) -> str:
    """A spread in pixels; unknown before the lens is known."""
    if not math.isfinite(value):
        return "unknown"
    return "more than 100 px" if value >= 100.0 else f"{value:.2f} px"


def board_line(state: LiveState) -> str:
    """State of the board."""
    if state.view is None:
        return f"not seen: {state.remark}"
    if state.taken or state.remark:
        return f"seen; {state.remark}"
    if state.still > 0.0:
        return "seen, stands still"
    return "seen, moves"


def known_line(state: LiveState) -> str:
    """Present and required knowledge of the lens."""
    return (
        f"largest spread {figure_px(state.cells.worst_px)}, wanted {state.cells.limit_px:g} px; "
        f"{focal_line(state)}"
    )


def focal_line(state: LiveState) -> str:
    """Precision of the focal length."""
    share = state.focal_share
    known = f"± {100.0 * share:.2f} %" if math.isfinite(share) else "unknown"
    return f"focal length {known}, wanted ± {100.0 * FOCAL_SHARE:g} %"


def wanted_line(state: LiveState) -> str:
    """Next position to hold the board in."""
    if state.done:
        return "enough: the board can be put down"
    if state.wanted is None:
        if state.count:
            return "hold the board where and as it was not held yet"
        return "the board fits into the picture nowhere: take a smaller one"
    return state.wanted.sentence


def cells_line(state: LiveState) -> str:
    """Finished share of the picture."""
    done = state.cells.done
    return f"{int(done.sum())} of {done.size} parts of the picture done"
