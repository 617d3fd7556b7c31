"""Admission to the page: connections, rights, and the one operator in control.

- `listener` accepts connections and cuts late or noisy ones; `connections` limits their number.
- `access` checks Host, Origin and token, and gives each visitor a role; `own_token` makes a token
  if none is configured.
- `allowance` limits the rate of messages; `seat` says who holds the arena.
"""
