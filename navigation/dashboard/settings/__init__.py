"""The configuration on the page: shown, checked while it is typed, saved with a way back.

`routes` holds the addresses below /api/settings; `desk` makes the form, checks the typed values,
writes the file and reloads the run.
"""
