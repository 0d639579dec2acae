"""Which effect is missing, or that it cannot be told.

In the order to read them: suggest, suggestion, ground, candidates, stand_ins, moments, panel, screening, hypothesis,
wrong_input, improve, next_run.
"""
