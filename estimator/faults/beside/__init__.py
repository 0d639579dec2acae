"""What the thermometers along the screw say of each other.

In the order to read them: local_heat, change, scatter, windows, neighbours.
"""
