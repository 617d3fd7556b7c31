"""The lens from views of a board: its model chosen, and the result in sentences."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from vision.calibrate.lens import estimate_lens
from vision.calibrate.lens_choice import choose_lens

if TYPE_CHECKING:
    from vision.calibrate.board import BoardView
    from vision.calibrate.lens import Lens


def lens_from_views(views: list[BoardView], terms: int | None, model: str) -> Lens:
    """Estimate the lens of these views, and print the remarks.

    ``model``: brown, fisheye, or auto. Raises ``CalibrationError`` as `estimate_lens` does.
    """
    lens = choose_lens(views, terms) if model == "auto" else estimate_lens(views, terms, model)
    for remark in lens.remarks:
        click.echo(remark, err=True)
    fx, fy = lens.camera_matrix[0, 0], lens.camera_matrix[1, 1]
    left_out_px = lens.left_out_rms_px
    left_out = "" if left_out_px is None else f", {left_out_px:.3f} px on ones left out"
    click.echo(
        f"lens: {lens.rms_px:.3f} px rms over {len(lens.used)} pictures{left_out}, "
        f"focal length {fx:.1f}, {fy:.1f} px, {lens.terms} distortion terms"
    )
    if lens.left_out_px and not any(math.isfinite(rms_px) for _, rms_px in lens.left_out_px):
        click.echo(
            f"model: {lens.model}; four pictures and more show which fits: --lens-model says which",
            err=True,
        )
    elif lens.left_out_px:
        both = ", ".join(f"{name} {_rms(rms_px)}" for name, rms_px in lens.left_out_px)
        click.echo(f"model: {lens.model}; on pictures left out by turns: {both}")
    return lens


def _rms(rms_px: float) -> str:
    return f"{rms_px:.3f} px rms" if math.isfinite(rms_px) else "no fit"
