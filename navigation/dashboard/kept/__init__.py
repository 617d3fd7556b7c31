"""Data kept on disk and shown on the page.

- `runs`: earlier runs and their files; `answers`: the same over HTTP.
- `places`: saved places.

A name from a page becomes part of a path only once it is recognised: a run's folder is named by a
time, and a file is one that a run writes. Links are not followed. The disk is read in worker
threads.
"""
