"""All attacks, in the order of the table, and the quick ones among them."""

from __future__ import annotations

from benchmarks.adversary.attack import Attack
from benchmarks.adversary.camera_attacks import ATTACKS as CAMERA
from benchmarks.adversary.disk_attacks import ATTACKS as DISK
from benchmarks.adversary.flood_attacks import ATTACKS as FLOOD
from benchmarks.adversary.line_attacks import ATTACKS as LINE
from benchmarks.adversary.process_attacks import ATTACKS as PROCESS

ATTACKS: tuple[Attack, ...] = (*LINE, *CAMERA, *PROCESS, *FLOOD, *DISK)

QUICK = tuple(one for one in ATTACKS if one.name in {"nothing is wrong"})
