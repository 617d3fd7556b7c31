"""Stands in for ``micropython``."""


def kbd_intr(character):
    assert character == -1, "Ctrl-C is a byte like others"


def native(function):
    """The decorator, which only the real one acts on."""
    return function
