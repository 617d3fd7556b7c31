"""Secrets that no outgoing text may show.

`secret_places` finds the secrets in the source of a configuration and in the environment. `secrets`
holds the words that make a key secret, remembers every secret that this process has read (`learn`),
and leaves them out of every outgoing text (`hide`).
"""
