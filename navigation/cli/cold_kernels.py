"""Compiles missing kernels before a command that computes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any, Literal

from navigation.cli.progress import CLEAR_LINE, is_live

Part = Literal["eye", "planner"]


def compile_what_is_missing(*parts: Part) -> None:
    """Compile the parts' kernels that are not kept yet, and count them on stderr."""
    missing: dict[str, tuple[Callable[..., None], tuple[Any, ...]]] = {
        part: (_work_of(part), ()) for part in parts if _is_cold(part)
    }
    if not missing:
        return
    from navigation.run.kernels.compiling import compile_parts

    first = "compiling the kernels, once on this machine"
    live = is_live()
    if not live:
        print(f"{first}: some minutes", file=sys.stderr, flush=True)
    for progress in compile_parts(missing):
        if live:
            sys.stderr.write(f"{CLEAR_LINE}{first}: {progress}")
            sys.stderr.flush()
    if live:
        sys.stderr.write(CLEAR_LINE)
        sys.stderr.flush()


def _is_cold(part: Part) -> bool:
    """True if a large kernel of the part is missing; unneeded ones are not imported."""
    from planner.shared.kernel_locator import is_compiled

    if part == "eye":
        from vision.outline.fitting_kernels import fit_borders
        from vision.outline.separated_border_kernels import fit_separated_borders

        return not (is_compiled(fit_borders) and is_compiled(fit_separated_borders))
    from planner.delaunay.insertion_kernels import triangulate

    return not is_compiled(triangulate)


def _work_of(part: Part) -> Callable[[], None]:
    from navigation.run.kernels.rehearsal import see_pictures
    from navigation.run.kernels.warm_up import compile_planner

    return see_pictures if part == "eye" else compile_planner
