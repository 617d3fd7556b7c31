"""All attacks, in the order of the table, and the quick ones among them."""

from __future__ import annotations

from benchmarks.adversary.attack import Attack
from benchmarks.adversary.line_attacks import ATTACKS as LINE

ATTACKS: tuple[Attack, ...] = (*LINE,)
QUICK = tuple(one for one in ATTACKS if one.name in {"nothing is wrong"})
