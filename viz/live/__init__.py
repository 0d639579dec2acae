"""Views of a run that goes on: live, outlet, rows, sure, minutes, body, room, repeat, scale, layout."""
