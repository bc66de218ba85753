"""Markers find their names: models of labelled point sets, and the fitting of them."""
