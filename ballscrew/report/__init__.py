"""What was found, as tables, sections, pictures and JSON.

In the order to read them: sections, use_report, review_report, review_views, comparison_report,
comparison_views, fit_report, tune_report, diagnosis_report, verdict, search_report, improvement_report.
"""
