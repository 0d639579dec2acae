"""Tables of a lab: lab."""
