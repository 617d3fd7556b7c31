"""Stands in for ``micropython``."""


def kbd_intr(character):
    assert character == -1, "Ctrl-C is a byte like others"
