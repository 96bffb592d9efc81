"""What every room may use and that knows none of them: errors, files, values, sources.

In: whatever a user gives. Out: a checked value, a whole file, or one clear sentence. Here you may
add a kind of value or of error; a module that imports another room belongs elsewhere.
"""
