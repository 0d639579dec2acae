"""Who does long work: threads for what is small, and processes that keep recordings; what travels to them: processes,
by_value."""
