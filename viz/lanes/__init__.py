"""Lanes below the curves, what is so from when to when: states, judged, lanes."""
