"""Files of results: netCDF layout and checks; progress of long work.

In: values by name. Out: files, whole or not at all, and what they hold, checked. A variable is one line
of a table in dataset.py: its dimensions, units and long name.
"""
