"""A plant: many rig folders, a row each: `ballscrew fleet`.

In the order to read them: inspection, workers, fleet_report, fleet_views.
"""
