"""A page to hand on: sections in, one HTML file out, that needs no network, light and dark, on a screen and on paper.

In the order to read them: page, section, colours, picture, then what a review is told by: headline, recordings, curves,
residual_map, equations, review_page; and the drift of an axis in the manner of ISO 230-3: iso230, iso230_section.
"""
