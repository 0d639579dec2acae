"""Where samples come from and where estimates go: logs, live buses, the virtual rig.

In the order to read them: recordings, ticker, silences, frames, canbus, received, budget, mended, foreign, units,
encoded.
"""
