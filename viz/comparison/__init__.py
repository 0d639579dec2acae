"""Views of two models beside each other."""
