"""Secrets that no outgoing text may show.

`secret_places` finds them in a configuration's source and in the environment. `secrets` remembers
all that this process has read (`learn`), and leaves them out of every outgoing text (`hide`).
"""
