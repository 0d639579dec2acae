"""Where and when heat is missing, and which readings are wrong.

In the order to read them: diagnose, missing_heat, blocks, zones, misfit, brought, causes, orders, follows, where,
wrong_reading, sentences.
"""
