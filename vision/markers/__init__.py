"""From a picture to the poses of robots: markers found, refined, identified and tracked."""
