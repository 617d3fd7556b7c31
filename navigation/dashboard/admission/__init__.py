"""Admission to the page: connections, rights, and the one operator in control.

- ``listener.py`` accepts connections and cuts late or noisy ones; ``places.py`` limits their
  number.
- ``access.py`` checks Host, Origin and token, and gives each visitor a role; ``own_token.py`` makes
  a token if none is configured.
- ``allowance.py`` limits the rate of a viewer's messages.
- ``seat.py`` says which operator holds the arena.
"""
