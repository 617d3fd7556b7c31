"""Data kept on disk and shown on the page.

- `runs`: earlier runs and their files; `answers`: the same over HTTP.
- `places`: saved places.

A name from a page becomes part of a path only once it is recognised. Links are not followed. The
disk is read in worker threads.
"""
