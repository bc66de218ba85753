"""The calibration screen: a board before the sensor, until its cameras are known well enough."""
