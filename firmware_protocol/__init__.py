"""The wire: messages, framing, and both ends of the serial link, sans-IO."""
