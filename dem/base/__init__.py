"""What every room may use: errors, files, values, hashes of sources. It imports no other room.

In: anything a user gives. Out: a checked value, a whole file, or one clear sentence. Here you may
add a type of value or of error; a module that imports another room belongs elsewhere.
"""
