"""The layout of flow.nc, as in dem.io.dataset: measures of all runs, and the snapshots of one a case."""

RUNS = ("case", "seed", "snapshot")
BED = ("case", "snapshot", "granule")

# name: (dimensions, units, long name)
VARIABLES = {
    "case": (("case",), None, "case: a shape at a density"),
    "seed": (("seed",), "1", "seed of the replicate"),
    "displacement": (("snapshot",), "m", "displacement of the cylinder"),
    "kind": (("case",), None, "kind of granule"),
    "shape": (("case",), None, "label of the shape"),
    "density": (("case",), "kg m-3", "density of the granules"),
    "aspect_ratio": (("case",), "1", "length over width of a granule"),
    "diameter": (("case",), "m", "mean volume diameter of the granules"),
    "non_affine": (RUNS, "1", "mean over the granules of D2min over the lag, over the squared diameter"),
    "fluctuation": (RUNS, "1", "mean distance of a granule from the motion of its neighbours over the lag, over that of the cylinder"),
    "mixing": (RUNS, "1", "share of pairs side by side that are of different layers, less that at the start"),
    "contacts_lost": (RUNS, "1", "share of the contacts at the start of the lag that are no more at its end"),
    "bed_height": (("case",), "m", "height of the box, run of the first seed"),
    "bed_cylinder_y": (("case", "snapshot"), "m", "height of the axis of the cylinder above the floor, run of the first seed"),
    "bed_diameter": (("case", "granule"), "m", "volume diameter of a granule, run of the first seed, NaN where the case has fewer"),
    "bed_x": (BED, "m", "distance of the granule's centre from the left wall, run of the first seed"),
    "bed_y": (BED, "m", "height of the granule's centre above the floor, run of the first seed"),
    "bed_angle": (BED, "rad", "angle of the granule, anticlockwise, run of the first seed"),
}  # fmt: skip

MEASURES = {
    "non_affine": "non-affine displacement",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost",
}
