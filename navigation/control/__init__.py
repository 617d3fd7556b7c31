"""Orders to a running daemon over a local socket; `navigation.orders` lists them.

- `server`: the thread that reads all clients at once and waits for none; `places`: the file that it
  listens at, made again if removed, and `abstract`: the socket without a file beside it; `clients`:
  the connections, their deadlines, and the order of leaving; `order_thread`: the threads that carry
  orders out, so that a stop waits for no other order.
- `ask`: the other end, for the command line, and `exchange`: one request of it.
- `peers`: the process at the other end, for both.

One request and one answer a connection, each one line of JSON; ``"again": true`` in an answer means
that there was no place, and that the request may be repeated. Only the owner can use the file (mode
0600, in a folder of mode 0700), and only the owner and root are served at the other socket.
"""

from navigation.control.ask import default_socket, send_order
from navigation.control.server import ControlServer
from navigation.orders.arguments import read_stations
from navigation.orders.carry_out import carry_out
from navigation.orders.errors import ControlError, NoDaemonError

__all__ = [
    "ControlError",
    "ControlServer",
    "NoDaemonError",
    "carry_out",
    "default_socket",
    "read_stations",
    "send_order",
]
