"""What is kept on disk and shown on the page: earlier runs with their files, places by name.

- `runs`: which runs there are, what each left behind, and the way from a name to a file.
- `answers`: the same over HTTP, in pages and in pieces.
- `places`: saved places, and the file beside the journal that keeps them.

Names that come from a page are never put together to paths before they have been recognised: a
run's folder has the name of a time, and a file is one of those that a run writes. Links are
not followed. The disk is read in worker threads, a little at a time.
"""
