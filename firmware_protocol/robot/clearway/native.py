"""MicroPython's module for its decorators, or one whose decorators do nothing.

MicroPython recognises only the exact ``@micropython.native``: modules with functions of every
control cycle import it from here.
"""

try:
    import micropython
except ImportError:

    class micropython:  # type: ignore[no-redef]  # noqa: N801
        """Replacement for MicroPython's module under CPython, for tests."""

        @staticmethod
        def native(function):  # type: ignore[no-untyped-def]
            """Leave a function as it is."""
            return function


__all__ = ["micropython"]
