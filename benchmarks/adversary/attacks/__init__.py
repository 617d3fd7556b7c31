"""All attacks, in the order of the table, and the quick ones among them."""

from __future__ import annotations

from benchmarks.adversary.attacks.attack import Attack
from benchmarks.adversary.attacks.by_crowds import ATTACKS as FLOOD
from benchmarks.adversary.attacks.on_drivers import ATTACKS as DRIVER
from benchmarks.adversary.attacks.on_processes import ATTACKS as PROCESS
from benchmarks.adversary.attacks.on_the_camera import ATTACKS as CAMERA
from benchmarks.adversary.attacks.on_the_disk import ATTACKS as DISK
from benchmarks.adversary.attacks.on_the_line import ATTACKS as LINE

ATTACKS: tuple[Attack, ...] = (*LINE, *CAMERA, *PROCESS, *DRIVER, *FLOOD, *DISK)

QUICK = tuple(
    one
    for one in ATTACKS
    if (one.kind, one.name)
    in {
        ("line", "every lease lost"),
        ("camera", "frozen, to the bit"),
        ("driver", "killed on a loaded computer"),
        ("driver", "frozen, the program ended"),
        ("flood", "64 viewers"),
    }
)
"""One of each kind of bar, under two minutes in all: these run with every test."""
