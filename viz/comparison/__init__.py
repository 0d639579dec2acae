"""Views of two models beside each other: comparison, compared, layout, curves, maps, heat."""
