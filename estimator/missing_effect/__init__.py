"""Which effect is missing, or that it cannot be told.

In the order to read them: suggest, side, suggestion, wrong_always, odd_run, wrong_input, begun, in_step,
improve, felt.
"""
