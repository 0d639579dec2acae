"""How a machine changes from run to run: every parameter's course over weeks, and which of them drifts.

In the order to read them: course, drift, trend.
"""
