"""The paper's own recipe for contours, corners and circles, for comparison."""
