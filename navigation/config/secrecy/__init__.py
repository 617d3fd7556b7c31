"""Secrets that no outgoing text may show.

`secret_places` finds them in the source of a configuration and in the environment. `secrets` knows
which keys are secret, remembers every secret that this process has read (`learn`), and leaves them
out of every outgoing text (`hide`).
"""
