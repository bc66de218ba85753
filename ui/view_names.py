"""What the views of a capture are called in the window; to be translated where they are shown."""

from adibas.texts import message

TURN = "turn"
"""Taken like a view: the patient turns around once before the sensor."""
VIEW_NAMES = {
    "anterior": message("Front"),
    "posterior": message("Back"),
    "right_lateral": message("Right side"),
    "left_lateral": message("Left side"),
    TURN: message("Slow turn"),
    "": message("No view"),
}
"""By the view's name in the core, and of the turn; left and right are the patient's."""
