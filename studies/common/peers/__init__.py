"""Other codes that run the same scenes: LAMMPS, LIGGGHTS and YADE, where they are installed.

A module of a code has these names:

NAME        of the code
SHAPES      classes of granules that it is timed with
available   function: None, or one sentence that says why it cannot be used
version     function: its release
seconds     function of (scene, state, time_step, warm, steps): time (s) of a number of steps, on one
            core, after `warm` others from the state; without reading and the first list of contacts
"""
