"""Effects of a user's own, named, written and printed: patience, named, own_effect, class_file, printed."""
