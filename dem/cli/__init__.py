"""The command line: a verb a stage. Exit status 0, 1 (a run failed) or 2 (bad input).

In: arguments and files. Out: files and sentences. Here you may add a verb; what it does is made in
the rooms below.
"""
