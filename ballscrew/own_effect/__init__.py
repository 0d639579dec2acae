"""Effects of a user's own, named, written and printed: patience, named, class_file, composed_file, printed."""
