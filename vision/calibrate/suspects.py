"""Foreign views: mirrored, upside down, of another camera, or spoiled.

Rules
- The lens fits the half of the views that agree best: least trimmed squares with the concentration
  steps of Rousseeuw and Van Driessen (1999), which a minority cannot move.
- A view is judged as it is, mirrored, and turned by half a turn. The lens distinguishes them only
  if its centre is off the picture's.
- Only a ChArUco board shows that all pictures are mirrored (`board`).
- For two cameras, each view repeatedly joins the better fitting lens (the classification EM of
  Celeux and Govaert 1992). They are two only if left-out views then fit clearly better.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vision.calibrate.board import BoardView
from vision.calibrate.left_out import Estimate, SeenThrough, left_out_px, residuals_px, rms_px
from vision.calibration.calibration import CalibrationError, FloatArray

_STARTS, _STEPS, _START_VIEWS = 6, 3, 4
_FEW = 6
"""Least number of views at which one half can be distinguished from the other."""
_BAD_FACTOR, _BAD_PX = 3.0, 0.5
_DOUBTFUL = 1.25
"""Factor by which faultless real views differ."""
_EXPLAINED = 0.7
"""Share of a view's rms that an explanation leaves at most: by chance never, at 20 corners."""
_OWN_LENS_VIEWS = 4
"""Least views of a lens of its own; fewer fit any."""
_PARTINGS = 5
_TWO_LENSES = 0.9
"""Share of left-out views' rms that two lenses leave at most: 0.84 for two very similar cameras,
0.94 at least for one (``python -m benchmarks.camera.boards``)."""


@dataclass(frozen=True, slots=True)
class Suspect:
    """A foreign view by its index, and the reason."""

    index: int
    reason: str


def mirrored(view: BoardView) -> BoardView:
    """The view in a mirrored picture."""
    corners = view.corners_px * (-1.0, 1.0) + (view.size[0] - 1.0, 0.0)
    return BoardView(view.name, view.size, corners, view.points_m * (-1.0, 1.0))


def upside_down(view: BoardView) -> BoardView:
    """The view in a picture turned by half a turn."""
    corners = np.array(view.size) - 1.0 - view.corners_px
    return BoardView(view.name, view.size, corners, view.points_m)


def suspects(views: Sequence[BoardView], estimate: Estimate) -> list[Suspect]:
    """Foreign views, the worst first; none of fewer than four."""
    if len(views) < 4:
        return []
    if len(views) < _FEW:
        found = _all_px(views, estimate(views))
        return _badly_fitting(found, float(np.median(found)), set())[:1]
    parted = _two_cameras(views, estimate)
    if parted is not None:
        return parted
    lens, usual_px = _agreed(views, estimate)
    found = _all_px(views, lens)
    named: dict[int, str] = {}
    for i in np.flatnonzero(found > _DOUBTFUL * usual_px).tolist():
        way = _turned_over([views[i]], lens, found[[i]])
        if way is not None:
            named[i] = f"the picture is {way}"
    foreign = [Suspect(i, f"{named[i]}: {_compared(found[i], usual_px)}") for i in named]
    foreign.sort(key=lambda one: -float(found[one.index]))
    return foreign + _badly_fitting(found, usual_px, set(named))


def bad_px(usual_px: float) -> float:
    """Rms from which a view is foreign to others with rms ``usual_px``."""
    return max(_BAD_PX, _BAD_FACTOR * usual_px)


def compared_with(
    views: Sequence[BoardView], foreign: Sequence[int], lens: SeenThrough, usual_px: float
) -> list[Suspect]:
    """Suspects for ``foreign`` views, by index, under the others' lens, with causes."""
    found = []
    for i in foreign:
        off_px = _all_px([views[i]], lens)
        way = _turned_over([views[i]], lens, off_px)
        why = "" if way is None else f"the picture is {way}: "
        found.append(Suspect(i, f"{why}{_compared(float(off_px[0]), usual_px)}"))
    return found


def refuse_too_many(views: Sequence[BoardView], found: Sequence[Suspect]) -> None:
    """Raise ``CalibrationError`` if more than a third of the views are foreign."""
    if 3 * len(found) <= len(views):
        return
    names = "; ".join(f"{views[one.index].name}: {one.reason}" for one in found)
    raise CalibrationError(
        f"{len(found)} of {len(views)} pictures do not belong to the others; at most a third may "
        f"be left out: {names}"
    )


def _all_px(views: Sequence[BoardView], lens: SeenThrough) -> FloatArray:
    return np.array([rms_px(residuals_px(view, lens)) for view in views])


def _agreed(views: Sequence[BoardView], estimate: Estimate) -> tuple[SeenThrough, float]:
    half = len(views) // 2 + 1
    rng = np.random.default_rng(0)
    best: tuple[float, SeenThrough] | None = None
    for _ in range(_STARTS):
        chosen = np.sort(rng.choice(len(views), _START_VIEWS, replace=False))
        try:
            for _ in range(_STEPS):
                lens = estimate([views[i] for i in chosen])
                found = _all_px(views, lens)
                chosen = np.sort(np.argsort(found)[:half])
        except CalibrationError:
            continue  # these few determine no lens
        trimmed = float(np.sum(np.sort(found)[:half] ** 2))
        if best is None or trimmed < best[0]:
            best = trimmed, lens
    lens = estimate(views) if best is None else best[1]
    # widen to all that agree: a half's residuals are smaller than usual
    for _ in range(2):
        found = _all_px(views, lens)
        usual_px = float(np.median(np.sort(found)[:half]))
        agreeing = found <= 2.0 * _DOUBTFUL * usual_px
        lens = estimate([view for view, fits in zip(views, agreeing, strict=True) if fits])
    found = _all_px(views, lens)
    return lens, float(np.median(found[agreeing]))


def _turned_over(views: Sequence[BoardView], lens: SeenThrough, found: FloatArray) -> str | None:
    """ "mirrored" or "upside down" if that explains the residuals."""
    ways = {"mirrored": mirrored, "upside down": upside_down}
    rms = {way: _mean_px(_all_px([over(v) for v in views], lens)) for way, over in ways.items()}
    best = min(rms, key=lambda way: rms[way])
    return best if rms[best] <= _EXPLAINED * _mean_px(found) else None


def _two_cameras(views: Sequence[BoardView], estimate: Estimate) -> list[Suspect] | None:
    """The smaller part of views that two lenses explain far better than one; else None."""
    if len(views) < 2 * _OWN_LENS_VIEWS:
        return None
    best: tuple[float, NDArray[np.bool_]] | None = None
    rng = np.random.default_rng(0)
    for _ in range(_STARTS):
        try:
            parted = _part(views, estimate, rng.choice(len(views), _START_VIEWS, replace=False))
        except CalibrationError:
            continue
        if parted is not None and (best is None or parted[0] < best[0]):
            best = parted
    if best is None:
        return None
    first = best[1] if 2 * np.count_nonzero(best[1]) >= len(views) else ~best[1]
    larger = [view for view, one in zip(views, first, strict=True) if one]
    smaller = [view for view, one in zip(views, first, strict=True) if not one]
    try:
        parts = [left_out_px(part, estimate) for part in (larger, smaller)]
        together = left_out_px(views, estimate)
        lens = estimate(larger)
    except CalibrationError:
        return None
    apart = np.concatenate(parts)
    if any(of(apart) > _TWO_LENSES * of(together) for of in (_mean_px, np.median)):
        return None  # of few views one at the edge, which the others' lens hardly knows, is most
    found = _all_px(views, lens)
    usual_px = float(np.median(found[first]))
    way = _turned_over(smaller, lens, found[~first])
    reason = "of another camera, zoom or focus" if way is None else f"the picture is {way}"
    return [
        Suspect(i, f"{reason}: {_compared(found[i], usual_px)}")
        for i in np.flatnonzero(~first).tolist()
    ] + _badly_fitting(found, usual_px, set(np.flatnonzero(~first).tolist()))


def _part(
    views: Sequence[BoardView], estimate: Estimate, start: NDArray[np.int64]
) -> tuple[float, NDArray[np.bool_]] | None:
    """Split views in two: (rms, mask of the first lens); None if a part is small."""
    found = _all_px(views, estimate([views[i] for i in start]))
    first = found <= np.median(found)
    for _ in range(_PARTINGS):
        if min(np.count_nonzero(first), np.count_nonzero(~first)) < _OWN_LENS_VIEWS:
            return None
        one, other = (
            _all_px(views, estimate([v for v, chosen in zip(views, part, strict=True) if chosen]))
            for part in (first, ~first)
        )
        nearer = one <= other
        if np.array_equal(nearer, first):
            break
        first = nearer
    if min(np.count_nonzero(first), np.count_nonzero(~first)) < _OWN_LENS_VIEWS:
        return None
    return _mean_px(np.minimum(one, other)), first


def _mean_px(found: FloatArray) -> float:
    return float(np.sqrt(np.mean(found * found)))


def _compared(found_px: float, usual_px: float) -> str:
    return f"{found_px:.2f} px rms where {usual_px:.2f} px is usual"


def _badly_fitting(found: FloatArray, usual_px: float, named: set[int]) -> list[Suspect]:
    limit_px = bad_px(usual_px)
    worst_first = [i for i in np.argsort(-found).tolist() if found[i] > limit_px and i not in named]
    return [Suspect(i, _compared(found[i], usual_px)) for i in worst_first]
