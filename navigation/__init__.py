"""Navigation Control: the running program.

The control loop is in this folder, from `eye` and `pilot` to `serial_link`; `daemon` runs it.
Around it, each in a folder: `config`, `draw`, `recording`, `simulator` and `machine` below;
`dashboard`, `run`, `sweep` and `cli` above.

``__init__.pyi`` lists what your own programs may use. Names are imported on first use, so `clearway
--help` needs none of them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
