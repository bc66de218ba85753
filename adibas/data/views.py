"""The four sides from which a patient is seen."""

VIEWS = ("anterior", "posterior", "right_lateral", "left_lateral")
