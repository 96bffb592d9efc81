"""The skin of the neighbour list: how far beyond contact it looks. It changes the speed alone."""

SKIN = 0.12  # of the mean bounding radius, in runs; timings are flat from 0.1 to 0.2
SKIN_OF_PACKING = 0.3  # while a bed is packed, where granules move far
MARGIN = 0.75  # share of skin / 2 that a constituent may move before the lists are rebuilt
