"""What was found, as tables, pages, pictures and JSON."""
