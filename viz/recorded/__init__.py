"""Views of recordings: recorded, run, layout, accuracy, sure, happened."""
