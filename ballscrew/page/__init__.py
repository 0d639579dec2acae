"""A page to hand on: sections in, one HTML file out, that needs no network, light and dark, on a screen and on paper.

In the order to read them: page, section, picture, then what a review is told by: headline, curves,
equations, review_page; of an improvement by improvement_page. The drift of an axis is in iso230/.
"""
