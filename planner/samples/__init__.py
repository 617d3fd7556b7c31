"""Pictures and a map to try things with; ``python -m benchmarks.figures.samples`` draws them.

``sample.py`` knows their names and where they are.
"""
