"""Place in a recording: playing or paused, speed and jumps.

Seconds; ``now_s`` is the caller's clock, the place counts from the recording's beginning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

SPEEDS: Final = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0)


@dataclass(slots=True)
class Player:
    """A playhead over ``duration_s``; ``jumps`` counts changes of the past."""

    duration_s: float
    playing: bool = True
    speed: float = 1.0
    jumps: int = 0
    _place_s: float = 0.0
    _since_s: float = 0.0

    def place_s(self, now_s: float) -> float:
        """Present place, at most the end."""
        passed_s = (now_s - self._since_s) * self.speed if self.playing else 0.0
        return min(self.duration_s, self._place_s + max(0.0, passed_s))

    def play(self, now_s: float) -> None:
        """Play; from the beginning if it is at the end."""
        if self.place_s(now_s) >= self.duration_s:
            self.seek(now_s, 0.0)
        self._hold(now_s)
        self.playing = True

    def pause(self, now_s: float) -> None:
        """Pause."""
        self._hold(now_s)
        self.playing = False

    def seek(self, now_s: float, place_s: float) -> None:
        """Jump to a place within the recording."""
        self._place_s = min(self.duration_s, max(0.0, place_s))
        self._since_s = now_s
        self.jumps += 1

    def set_speed(self, now_s: float, speed: float) -> None:
        """Set one of `SPEEDS`; ValueError for any other."""
        if speed not in SPEEDS:
            raise ValueError(f"speed: must be one of {', '.join(f'{one:g}' for one in SPEEDS)}")
        self._hold(now_s)
        self.speed = speed

    def _hold(self, now_s: float) -> None:
        self._place_s, self._since_s = self.place_s(now_s), now_s
