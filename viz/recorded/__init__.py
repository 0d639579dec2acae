"""Views of recordings: recorded, run, layout, accuracy, misfits, sure, happened."""
