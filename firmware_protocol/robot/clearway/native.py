"""MicroPython's own module, for its decorators; under CPython one whose decorators do nothing.

The decorator ``@micropython.native`` is recognised by these very words: modules whose functions run
in every control cycle import the name from here.
"""

try:
    import micropython
except ImportError:

    class micropython:  # type: ignore[no-redef]  # noqa: N801
        """Stands in for MicroPython's module under CPython, which tests run it on."""

        @staticmethod
        def native(function):  # type: ignore[no-untyped-def]
            """Leave a function as it is."""
            return function


__all__ = ["micropython"]
