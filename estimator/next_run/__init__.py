"""Which run to make next: the one that settles what a search has left open, as the hypotheses foretell it.

In the order to read them: next_run, question, plans, foretold, surroundings.
"""
