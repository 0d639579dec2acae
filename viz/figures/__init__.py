"""Figures drawn by hand, each a view of its own, for the viewer has no map with names and no curve over a place: map,
along."""
