"""Views of recordings: recorded, run, layout, accuracy, happened."""
