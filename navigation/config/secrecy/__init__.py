"""Secrets that no outgoing text may show.

``secret_places.py`` finds the secrets in the source of a configuration, node by node in sound YAML
and line by line in broken text, and in the environment. ``secrets.py`` holds the words that make a
key secret, remembers every secret that this process has read (`learn`), and leaves them out of
every outgoing text (`hide`).
"""
