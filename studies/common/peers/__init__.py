"""Other codes that run the same scenes: LAMMPS and YADE, where they are installed.

A code, which is a module or an object of one, has these names:

NAME        of the code
SHAPES      classes of granules that it is timed with
available   function: None, or one sentence that says why it cannot be used
version     function: its release
seconds     function of (scene, state, time_step, warm, steps): processor time (s) of a number of steps, on one
            core, after `warm` others from the state; without reading and the first list of contacts
"""
