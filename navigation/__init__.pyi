# The public names, and their modules: the one list of them.
from .config.errors import ConfigError as ConfigError
from .config.load import load_config as load_config
from .config.sections import Config as Config
from .draw.picture import DrawError as DrawError
from .draw.picture import draw_svg as draw_svg
from .draw.picture import save_picture as save_picture
from .link.link_snapshot import LinkSnapshot as LinkSnapshot
from .link.serial_link import SerialLink as SerialLink
from .link.serial_port import PortError as PortError
from .mission.targets import targets_of as targets_of
from .mission.targets import to_wire as to_wire
from .simulator.robot import SimulatedRobot as SimulatedRobot
