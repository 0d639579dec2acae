"""Lanes below the curves, what is so from when to when, and what is so now in large letters: states, standing,
lanes, banner."""
