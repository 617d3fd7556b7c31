"""Values that hardly any argument takes, and what a function has to answer to them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

WRONG: dict[str, Any] = {
    "None": None,
    "a word": "three",
    "bytes": b"x",
    "a number": 3.5,
    "a negative number": -1,
    "nan": float("nan"),
    "inf": float("inf"),
    "numbers": [1.0, 2.0, 3.0],
    "nothing": [],
    "words": ["a", "b"],
    "ragged rows": [[1, 2], [3]],
    "a cube": np.zeros((2, 2, 2)),
    "rows of nan": np.full((2, 2), np.nan),
    "an array": np.zeros(3),
    "a mapping": {"a": 1},
    "an object": object(),
}
LONGEST = 300


def refuses(call: Callable[[Any], Any], named: str, fine: str) -> None:
    """Give each wrong value to ``call``, but for the ``fine`` ones, "a, b", which it takes.

    What is refused is a TypeError or ValueError of one sentence that names the argument.
    """
    taken = set(fine.split(", ")) - {""}
    assert taken <= set(WRONG)
    for name, value in WRONG.items():
        if name in taken:
            call(value)
            continue
        with pytest.raises((TypeError, ValueError)) as refused:
            call(value)
        message = str(refused.value)
        assert named in message, f"{name}: {message!r} does not name {named!r}"
        assert "\n" not in message.strip(), name
        assert len(message) < LONGEST, name
