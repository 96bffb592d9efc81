"""A scene in motion: arrays, kinds of scenes, neighbour list, motion, forces, stable step, energy, threads.

In: a Scene and a State. Out: the State later, records, diagnostics, a ledger, a checkpoint. Here
you may change how a step is taken or chosen, add a body that granules meet, or something to record.
"""
