"""The layout of precision.nc, as in dem.io.dataset."""

# name: (dimensions, units, long name)
VARIABLES = {
    "row_rule": (("row",), None, "rule that says how many runs there are"),
    "row_source": (("row",), None, "distribution of what a run gives, or case whose runs are drawn again"),
    "row_scatter": (("row",), "1", "standard deviation of one run over the mean"),
    "row_target": (("row",), "1", "half the interval that is asked for over the mean"),
    "row_samples": (("row",), "1", "how many times the rule was tried"),
    "row_asked": (("row",), "1", "share of trials whose mean is as near as asked for; where runs ended before, whose interval holds the true mean"),
    "row_found": (("row",), "1", "share of trials whose interval, as narrow as it came out, holds the true mean"),
    "row_within": (("row",), "1", "share of trials whose mean is as near as asked for, wherever they ended"),
    "row_half": (("row",), "1", "half the interval as it came out over the mean, averaged over the trials"),
    "row_short": (("row",), "1", "share of trials that end with a wider interval than asked for"),
    "row_runs": (("row",), "1", "number of runs, averaged over the trials"),
    "row_needed": (("row",), "1", "number of runs that the true scatter asks for"),
}  # fmt: skip
