"""What begins within a run, at a time that nobody has told: when, where, how much, and what it may be.

In the order to read them: events, event, spans, carriers, signature, pattern, onset, kinds, short,
readings, growing, taken_out.
"""
