"""Hypotheses of what is missing: effects beside a model, judged by what they predict on recordings left out.

In the order to read them: ground, slopes, moments, panel, candidates, hypothesis, criterion, screening.
"""
