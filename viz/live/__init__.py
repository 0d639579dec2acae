"""Views of a run that goes on: live, outlet, rows, readings, table, sure, minutes, body, repeat, scale, layout."""
