"""The configuration on the page: shown, checked while it is typed, saved with a way back.

``routes.py`` holds the addresses below /api/settings and lets operators in by
`navigation.dashboard.visits`. ``desk.py`` does the work: it makes the form from the configuration's
file (`navigation.config.editing`), checks the typed values as `clearway check` would, keeps the
earlier text, writes the file and reloads the run; undo puts the earlier text back.
"""
