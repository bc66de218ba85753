"""What the views of a capture are called in the window; to be translated where they are shown."""

from adibas.texts import message

VIEW_NAMES = {
    "anterior": message("Front"),
    "posterior": message("Back"),
    "right_lateral": message("Right side"),
    "left_lateral": message("Left side"),
    "turn": message("Slow turn"),
    "": message("No view"),
}
"""By the view's name in the core; left and right are the patient's."""
