"""Which channels are broken, by what they read against the model and each other.

In the order to read them: fault, jumps, standstill, machine, beside, suspects, recovery, judge, travel, use, sentences.
"""
