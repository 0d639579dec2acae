"""Views of a tuning."""
