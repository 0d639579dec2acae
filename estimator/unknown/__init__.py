"""What no catalogue has: found by stand-ins, and written down as an effect.

In the order to read them: stand_ins, unexplained, law, effect_text, written, composed.
"""
