"""Files of results: netCDF layout and checks, progress, the folder that a workflow works in.

In: values by name. Out: files, whole or not at all, and what they hold, checked. Here you may add
a variable (one line of dataset.VARIABLES), its units and its long name.
"""
