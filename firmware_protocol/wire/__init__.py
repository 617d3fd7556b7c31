"""What goes over the wire: framing, messages and their numbers; knows no end of it."""
