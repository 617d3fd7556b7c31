# The public names: the one list of them.
from .names import NoPath as NoPath
from .names import Path as Path
from .names import Roadmap as Roadmap
from .names import Scene as Scene
from .names import build_roadmap as build_roadmap
from .names import extract as extract
from .names import load_scene as load_scene
from .names import sample as sample
from .names import save_picture as save_picture
from .names import time_path as time_path

__version__: str
