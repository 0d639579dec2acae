"""What was found, as tables, sections, pictures and JSON; of a search for a missing effect in `search`.

In the order to read them: sections, use_report, review_report, review_views, comparison_report,
comparison_views, fit_report, tune_report, diagnosis_report, felt_report, improvement_report, trend_report.
"""
