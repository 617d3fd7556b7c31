"""Orders to a running daemon over a local socket; `navigation.orders` lists them.

- `server` reads all clients at once and waits for none, at the file of `places` and at the socket
  without a file of `abstract`; `clients` are the connections; `order_thread` carries orders out, so
  that a stop waits for no other order.
- `ask` is the other end, for the command line; `exchange` is one request of it.
- `peers` names the process at the other end, for both.

One request and one answer a connection, each one line of JSON; ``"again": true`` in an answer means
that there was no place. Only the owner can use the file (mode 0600, in a folder of mode 0700); only
the owner and root are served at the other socket.
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
