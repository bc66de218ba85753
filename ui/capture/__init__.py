"""Live view of the sensor, and the capture of the patient's views."""
