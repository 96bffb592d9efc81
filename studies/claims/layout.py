"""The layout of claims.nc, as in dem.io.dataset."""

RUN = ("run",)
MEASURES = {  # of how irregularly beds move, as dem.experiment.observables.flow names them
    "non_affine": "non-affine displacement",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost",
}

# name: (dimensions, units, long name)
VARIABLES = {
    "run_part": (RUN, None, "part of the study: replicates, sensitivity, matched, ratios or scaling"),
    "run_case": (RUN, None, "case, or shape where there is no case"),
    "run_shape": (RUN, None, "label of the shape"),
    "run_setting": (RUN, None, "what is equal or varied"),
    "run_x": (RUN, "1", "what varies: packing fraction (matched), aspect ratio (ratios), factor on the sweep's value (scaling)"),
    "run_point": (RUN, "1", "point of the design, -1 for runs of other parts"),
    "run_seed": (RUN, "1", "seed of the replicate"),
    "run_density": (RUN, "kg m-3", "density of the granules"),
    "run_packing": (RUN, "1", "packing fraction"),
    "run_status": (RUN, None, "ran, or the error that stopped the run"),
    "run_drag": (RUN, "N", "mean drag in the window, NaN where the run failed"),
    "run_spent": (RUN, "s", "processor time of bed, run and measures, with compiling where it was the first"),
    "run_non_affine": (RUN, "1", "mean of D2min over the squared diameter in the window"),
    "run_fluctuation": (RUN, "1", "mean distance of a granule from the motion of its neighbours, over that of the cylinder, in the window"),
    "run_mixing": (RUN, "1", "share of pairs side by side that are of different layers, less that at the start, mean in the window"),
    "run_contacts_lost": (RUN, "1", "share of contacts lost in a lag, mean in the window"),
    "run_factor": (("run", "factor"), "1", "values of the design, SI units; of a choice, its number; NaN for other parts"),
    "run_curve": (("run", "place"), "N", "drag along the displacement"),
    "run_alignment": (("run", "moment"), "1", "mean of cos 2(angle - direction of motion) of the granules near the cylinder"),
    "run_alignment_start": (("run", "moment"), "1", "the same with the angles that these granules had at the start"),
    "run_streaming": (("run", "moment"), "1", "mean of cos 2(angle - direction of motion past the cylinder) of the granules near it"),
    "run_streaming_start": (("run", "moment"), "1", "the same with the angles that these granules had at the start"),
    "reference_shape": ((), None, "shape to which others are compared: that of the sweep's first case"),
    "reference_density": ((), "kg m-3", "density of the sweep's first case"),
    "reference_packing": ((), "1", "packing fraction of the sweep"),
    "factor": (("factor",), None, "value of the configuration, by its path"),
    "place": (("place",), "m", "displacement of the cylinder"),
    "moment": (("moment",), "m", "displacement of the cylinder at the end of the motion"),
    "jam_shape": (("jam",), None, "label of the shape, or aspect ratio of an ellipse"),
    "jam_diameter": (("jam",), "m", "mean volume diameter of the granules"),
    "jam_seed": (("jam",), "1", "seed of the bed"),
    "jam_friction": (("jam",), "1", "coefficient of friction while the granules grow"),
    "jam_fraction": (("jam",), "1", "packing fraction at which the bed jams"),
    "jam_slope": (("jam",), "1", "slope of load^(2/3) against packing fraction"),
}  # fmt: skip
