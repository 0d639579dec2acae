"""Views of two models beside each other: comparison, compared, curves, maps, heat."""
