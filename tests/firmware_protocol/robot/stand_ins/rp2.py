"""Stands in for ``rp2``."""

import world


def bootsel_button():
    return int(world.held_at_boot)
