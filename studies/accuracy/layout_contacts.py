"""The layout of the study of contacts: single ones, and thousands of bounces, as in dem.io.dataset."""

METHOD, STRATUM = ("contact_method",), ("contact_aspect_ratio", "contact_overlap")
BOUNCES = ("bounce_method", "bounce_aspect_ratio", "bounce_run")
EACH = (*METHOD, *STRATUM, "contact_start")

# name: (dimensions, units, long name)
VARIABLES = {
    "contact_method": (METHOD, None, "method: kind, and tolerance or number of sides"),
    "contact_kind": (METHOD, None, "kind of method"),
    "contact_remembers": (METHOD, "1", "1 for a method that starts from the normal of the last step, 0 for one that begins again"),
    "contact_aspect_ratio": (("contact_aspect_ratio",), "1", "aspect ratio of both ellipses"),
    "contact_overlap": (("contact_overlap",), "1", "overlap over the smaller minor semi-axis b"),
    "contact_start": (("contact_start",), None, "normal that is remembered: up to so far off the right one; cold: the line of centres"),
    "contact_pairs": ((), "1", "number of pairs a stratum"),
    "contact_checked_pairs": ((), "1", "number of these compared with the definitions in extended precision"),
    "contact_gap": ((), "1", "gap over b of pairs that are near but apart"),
    "contact_truth_error": (STRATUM, "1", "difference of the constructed contact from one found with 50 digits: greater of overlap, over the mean volume radius, and normal, in rad"),
    "contact_time": ((*EACH, "contact_repeat"), "s", "time to find a contact, one core"),
    "contact_reject_time": ((*METHOD, "contact_aspect_ratio", "contact_start", "contact_repeat"), "s", "time to find that a pair is apart, one core"),
    "contact_failures": (EACH, "1", "share of pairs that are missed, or whose overlap is off by more than 10 % or normal by more than 0.1 rad"),
    "contact_overlap_error": (EACH, "1", "worst error of the overlap over the overlap; 1 for a contact that is missed"),
    "contact_overlap_error_median": (EACH, "1", "median error of the overlap over the overlap"),
    "contact_normal_error": (EACH, "rad", "worst error of the normal"),
    "contact_normal_error_median": (EACH, "rad", "median error of the normal"),
    "contact_point_error": (EACH, "1", "worst error of the contact point over b"),
    "contact_point_error_median": (EACH, "1", "median error of the contact point over b"),
    "contact_solver_misses": (EACH, "1", "share of pairs where either solver or definition, and not both, has a contact"),
    "contact_solver_overlap_error": (EACH, "1", "worst error of the overlap against the method's own definition, over that overlap"),
    "contact_solver_normal_error": (EACH, "rad", "worst error of the normal against the method's own definition"),
    "contact_solver_point_error": (EACH, "1", "worst error of the contact point against the method's own definition, over b"),
    "contact_definition_failures": ((*METHOD, *STRATUM), "1", "failures of the definition evaluated without error"),
    "contact_definition_overlap_error": ((*METHOD, *STRATUM), "1", "worst error of the overlap by the definition evaluated without error, over the overlap"),
    "contact_definition_overlap_error_median": ((*METHOD, *STRATUM), "1", "median error of the overlap by the definition evaluated without error"),
    "contact_definition_normal_error": ((*METHOD, *STRATUM), "rad", "worst error of the normal by the definition evaluated without error"),
    "contact_definition_normal_error_median": ((*METHOD, *STRATUM), "rad", "median error of the normal by the definition evaluated without error"),
    "contact_definition_point_error": ((*METHOD, *STRATUM), "1", "worst error of the contact point by the definition evaluated without error, over b"),
    "contact_definition_point_error_median": ((*METHOD, *STRATUM), "1", "median error of the contact point by the definition evaluated without error"),
    "bounce_method": (("bounce_method",), None, "granules and, of ellipses, method and radius of Hertz's law: constant unless local"),
    "bounce_aspect_ratio": (("bounce_aspect_ratio",), "1", "aspect ratio of the granules"),
    "bounce_number": (("bounce_number",), "1", "number of bounces between granules, frictionless and elastic"),
    "bounce_energy": ((*BOUNCES, "bounce_number"), "1", "total energy over that at the start, read when nothing touches"),
    "bounce_burst": (BOUNCES, "1", "number of bounces until the energy has grown 100-fold, or the run has failed"),
    "bounce_overlap": ((), "1", "greatest overlap over the radius in a head-on collision at the first rms speed"),
    "bounce_steps": ((), "1", "time steps in such a collision"),
}  # fmt: skip
