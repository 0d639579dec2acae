"""Views of recordings: recorded, run, layout, accuracy, misfits, sure, at_table, happened."""
