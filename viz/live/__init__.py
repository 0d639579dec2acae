"""Views of a run that goes on."""
