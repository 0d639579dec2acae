"""The drift of an axis at fixed positions of its table, in the manner of ISO 230-3.

In the order to read them: positions, drift, drift_picture, drift_section.
"""
