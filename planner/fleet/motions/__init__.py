"""Discs on straight lines: contact times, and the earliest arrival among moving discs.

- ``motion_kernels`` computes in closed form when two moving discs touch.
- ``interval_search_kernels`` finds one robot's earliest arrival among others.
- ``track_kernels`` measures how near whole tracks come, and orders robots at shared places.
"""
