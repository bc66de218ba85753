"""Energies of labellings of an image, and graph cuts that lower them."""
