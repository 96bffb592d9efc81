"""Kinds of experiment, one file each; the folder is the list.

Constants at the top are read without importing the file:

SECTIONS   sections of the configuration that it reads beside those of all, and whether it needs them
ASKS       values that it asks for, by path, and why
OBSERVED   True where it records record.observables, and takes bed and checkpoint
BED_ALONE  True where it reads nothing but what makes the bed

run(replicate, bed=None, progress=..., ...)   variables of a run by name; bed: at rest, packed here if None
layout(configuration), axes(configuration), sizes(replicate)    as in dem.io.dataset
motions(replicate)                            what selects the machine code of what it moves
"""
