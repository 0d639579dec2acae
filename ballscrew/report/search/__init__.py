"""What a search for a missing effect found, in words and numbers.

In the order to read them: search_report, verdict, composed_words, next_run_words; of `improve`:
improvement_parts.
"""
