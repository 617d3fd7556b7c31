"""Global Vision: from a picture to a scene and robot poses."""
