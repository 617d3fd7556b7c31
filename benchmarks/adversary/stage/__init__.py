"""What stands in for the world around the program: line, camera, robot and crowds, with faults."""
