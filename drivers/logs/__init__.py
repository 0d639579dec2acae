"""Files of frames and tables: readers, writers, and truth beside them."""
