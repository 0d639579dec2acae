"""Views of a run that goes on: live, outlet, rows, minutes, body, room, repeat, scale, layout."""
