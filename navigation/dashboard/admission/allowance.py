"""Rate limit for one connection. Seconds of the caller's clock."""

from __future__ import annotations


class Allowance:
    """Limit of ``rate_s`` messages a second, for ``burst_s`` at once."""

    def __init__(self, rate_s: float, burst_s: float, now_s: float) -> None:
        self._rate_s, self._most = rate_s, rate_s * burst_s
        self._left, self._since_s = self._most, now_s

    def take(self, now_s: float) -> bool:
        """Count one more; False if it is one too many."""
        self._left = min(self._most, self._left + self._rate_s * (now_s - self._since_s))
        self._since_s = now_s
        self._left -= 1.0
        return self._left >= 0.0
