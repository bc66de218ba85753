"""The map dialog: a recording of a moving camera, or of a turning patient, as one surface."""
