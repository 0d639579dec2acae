"""The machines of one build: constants (a machine's numbers and the ranges they come from), draw (machine number N
that can follow the protocol)."""
