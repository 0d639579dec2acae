"""Effects of a user's own: named, written, checked: named, own_effect, class_file."""
