"""Views of a run that goes on: live, outlet, rows, readings, table, sure, minutes, body, room, repeat, scale,
layout."""
