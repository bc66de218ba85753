"""Limbs of a person in a depth image: labels of pixels by forest and graph cut."""
