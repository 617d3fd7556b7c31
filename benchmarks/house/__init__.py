"""The code's own figures, counted from the code: ``python -m benchmarks.house``.

``tree`` reads the files, ``counts`` looks at them one by one, ``imports`` between them,
``documents`` beside them; ``figures`` puts a limit to each count. ``layers`` and ``drawing`` make
the picture of the folders from the same imports, ``files`` the page that names every file.
"""
