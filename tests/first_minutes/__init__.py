"""The first minutes of a newcomer: the documents' own commands, from a wheel in a new environment.

- `conftest` builds the wheel once and installs it.
- `test_first_minutes` runs what the README and the tutorial say, in their order.
"""
