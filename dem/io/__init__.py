"""Files of results: netCDF layout and checks, progress, the folder that a workflow works in.

In: values by name. Out: files, whole or not at all, and what they hold, checked. A variable is one line
of a table in dataset.py: its dimensions, units and long name.
"""
