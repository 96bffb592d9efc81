"""Do shapes compare at equal pressure as at equal packing fraction, and how wide must the box
be?"""
