"""Data kept on disk and shown on the page: earlier runs with their files, places by name.

- `runs`: the runs, the files of each, and the way from a name to a file.
- `answers`: the same over HTTP, in pages and in pieces.
- `places`: saved places, and the file beside the journal that keeps them.

A name from a page becomes part of a path only once it is recognised: a run's folder is named by a
time, and a file is one that a run writes. Links are not followed. The disk is read in worker
threads, a little at a time.
"""
