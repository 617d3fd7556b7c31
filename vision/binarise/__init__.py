"""From a picture to a mask of obstacles, and how sure each border of it is."""
