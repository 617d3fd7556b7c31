"""Scenes and maps as files: scene texts, ROS maps, MovingAI maps."""
