"""Effects of a user's own: named, written, checked."""
