"""The paper's recipe on ragged pictures: its records are drawable, whatever its vertices.

Rules and units
- Whole pixels, y down; outlines run clockwise on the screen, holes counter-clockwise.
"""

from __future__ import annotations

import numpy as np
import pytest

from vision import extract


@pytest.mark.parametrize("share", [0.15, 0.3, 0.5])
def test_the_paper_s_outlines_have_sides_and_run_clockwise(share: float) -> None:
    """Specks' vertices once came twice in a row, or ran the other way round."""
    for seed in range(20):
        rng = np.random.default_rng([seed, 23])
        picture = np.where(rng.random((60, 60)) < share, 0, 255).astype(np.uint8)
        for found in extract(picture, mode="paper", threshold=128).objects:
            for record, sign in [(r, 1) for r in found.records] + [
                (r, -1) for hole in found.holes for r in hole
            ]:
                edges = getattr(record, "edges", ())
                assert all(e.start != e.end for e in edges), seed
                at = [e.start for e in edges]
                turn = sum(
                    at[i - 1][0] * at[i][1] - at[i - 1][1] * at[i][0] for i in range(len(at))
                )
                assert sign * turn >= 0.0, seed
