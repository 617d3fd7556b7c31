"""Navigation Control: the running program.

The control loop is on this floor, from `eye` and `pilot` to `serial_link`; `daemon` turns it.
Around it, each in a folder: `config`, `draw`, `recording`, `simulator` and `machine` below;
`dashboard`, `run`, `sweep` and `cli` above.

``__init__.pyi`` lists what programs of your own may use. Names are imported on first use, so that
`clearway --help` needs none of them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
