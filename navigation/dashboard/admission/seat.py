"""The seat: at most one operator holds the arena; the others watch, and may stop the robot.

Rules
- The first to ask takes a free seat. A supervisor takes it from anyone, at once.
- A holder loses it after ``idle_s`` without acting, or when away for longer than a page takes to
  reload (``LEFT_S``) or a lost connection to come back (``AWAY_S``).
- A key that only the holder's page knows identifies the holder.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace

AWAY_S = 20.0
LEFT_S = 4.0


@dataclass(frozen=True, slots=True)
class Holder:
    """The holder of the arena: secret key, name that others see, signs of life."""

    key: str
    name: str
    active_s: float
    back_until_s: float | None = None
    """While away: the time limit to come back."""

    @property
    def public(self) -> str:
        """Part of the key that others may know."""
        return public_half(self.key)


def public_half(key: str) -> str:
    """A digest that distinguishes keys and gives none away."""
    return hashlib.sha256(key.encode()).hexdigest()[:12]


class Seat:
    """The seat and its rules."""

    def __init__(self, idle_s: float) -> None:
        self.idle_s = idle_s
        self.holder: Holder | None = None

    def take(self, key: str, name: str, now_s: float, *, from_anyone: bool = False) -> str | None:
        """Take the seat, if it is free or ``from_anyone``; return None, or why not."""
        holder = self.holder
        if holder is not None and holder.key != key and not from_anyone:
            left_s = self.free_in_s(now_s)
            return f"{holder.name} is in control (until {left_s:.0f} s pass without an order)"
        self.holder = Holder(key, name, now_s)
        return None

    def release(self, key: str) -> bool:
        """Leave the seat; True if this key held it."""
        if not self.is_held_by(key):
            return False
        self.holder = None
        return True

    def is_held_by(self, key: str) -> bool:
        """True if this key holds the arena."""
        return self.holder is not None and self.holder.key == key

    def touch(self, key: str, now_s: float) -> None:
        """Note that the holder acted."""
        if self.holder is not None and self.holder.key == key:
            self.holder = replace(self.holder, active_s=now_s, back_until_s=None)

    def come(self, key: str, name: str) -> None:
        """Note that the holder's connection is here, by this name."""
        if self.holder is not None and self.holder.key == key:
            self.holder = replace(self.holder, name=name, back_until_s=None)

    def go(self, key: str, now_s: float, *, left: bool) -> None:
        """Note that the holder's connection ended; ``left`` as a closed page does."""
        if self.holder is not None and self.holder.key == key:
            until_s = now_s + (LEFT_S if left else AWAY_S)
            self.holder = replace(self.holder, back_until_s=until_s)

    def free_in_s(self, now_s: float) -> float:
        """Seconds until an idle seat is free."""
        holder = self.holder
        if holder is None:
            return 0.0
        left_s = holder.active_s + self.idle_s - now_s
        if holder.back_until_s is not None:
            left_s = min(left_s, holder.back_until_s - now_s)
        return max(0.0, left_s)

    def tick(self, now_s: float) -> str | None:
        """Free the seat when due, and say so."""
        holder = self.holder
        if holder is None or self.free_in_s(now_s) > 0.0:
            return None
        self.holder = None
        why = "did nothing for a while" if holder.back_until_s is None else "went away"
        return f"{holder.name} {why}: no one is in control"
