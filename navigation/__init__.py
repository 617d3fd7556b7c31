"""Navigation Control: the running program, one folder for each part.

- `loop` is the control loop: it sees, plans and sends once a cycle. It uses `mission` (the state
  and the pilot's decisions), `witness` (camera against wheels), `fleet` (several robots) and
  `link` (the serial line).
- Below it: `config`, `draw`, `journal`, `recording`, `simulator`, `machine` and `shared`.
- Above it: `orders` and `control` (orders to a running program), `dashboard`, `run`, `sweep` and
  `cli`.

``__init__.pyi`` lists the names for your own programs. They are imported on first use, so that
`clearway --help` needs none of them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
