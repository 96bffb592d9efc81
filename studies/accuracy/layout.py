"""The layout of accuracy.nc, as in dem.io.dataset: contacts, single and bouncing; time steps; the drag."""

METHOD, STRATUM = ("contact_method",), ("contact_aspect_ratio", "contact_overlap")
BOUNCES = ("bounce_method", "bounce_aspect_ratio", "bounce_run")
EACH = (*METHOD, *STRATUM, "contact_start")

# name: (dimensions, units, long name)
CONTACTS = {
    "contact_method": (METHOD, None, "method: kind, and tolerance or number of sides"),
    "contact_kind": (METHOD, None, "kind of method"),
    "contact_remembers": (METHOD, "1", "1 for a method that starts from the normal of the last step, 0 for one that begins again"),
    "contact_aspect_ratio": (("contact_aspect_ratio",), "1", "aspect ratio of both ellipses"),
    "contact_overlap": (("contact_overlap",), "1", "overlap over the smaller minor semi-axis b"),
    "contact_start": (("contact_start",), None, "normal that is remembered: up to so far off the right one; cold: the line of centres"),
    "contact_time": ((*EACH, "contact_repeat"), "s", "time to find a contact, one core"),
    "contact_failures": (EACH, "1", "share of pairs that are missed, or whose overlap is off by more than 10 % or normal by more than 0.1 rad"),
    "contact_overlap_error": (EACH, "1", "worst error of the overlap over the overlap; 1 for a contact that is missed"),
    "contact_solver_overlap_error": (EACH, "1", "worst error of the overlap against the method's own definition, over that overlap"),
    "contact_solver_normal_error": (EACH, "rad", "worst error of the normal against the method's own definition"),
    "contact_definition_overlap_error": ((*METHOD, *STRATUM), "1", "worst error of the overlap by the definition evaluated without error, over the overlap"),
    "contact_definition_normal_error": ((*METHOD, *STRATUM), "rad", "worst error of the normal by the definition evaluated without error"),
    "bounce_method": (("bounce_method",), None, "granules and, of ellipses, method and radius of Hertz's law: constant unless local"),
    "bounce_aspect_ratio": (("bounce_aspect_ratio",), "1", "aspect ratio of the granules"),
    "bounce_number": (("bounce_number",), "1", "number of bounces between granules, frictionless and elastic"),
    "bounce_energy": ((*BOUNCES, "bounce_number"), "1", "total energy over that at the start, read when nothing touches"),
    "bounce_burst": (BOUNCES, "1", "number of bounces until the energy has grown 100-fold, or the run has failed"),
    "bounce_steps": ((), "1", "time steps in a head-on collision at the first rms speed"),
}  # fmt: skip
STEPS = {
    "step_scene": (("step_scene",), None, "what is integrated"),
    "integrator": (("integrator",), None, "time integrator"),
    "step_default": ((), "1", "time step over the critical one that a simulation takes unless told"),
    "step_fraction": (("step_scene", "step_level"), "1", "time step over the critical one"),
    "step_error": (("step_scene", "integrator", "step_level"), "1", "rms error: of velocities after a collision over the speed of impact, of displacements in a bed over that of the cylinder"),
    "step_time": (("step_scene", "integrator", "step_level", "step_repeat"), "s", "processor time of one collision, or of the run of a bed"),
    "step_order": (("step_scene", "integrator"), "1", "order of convergence of the error, fitted to the smallest steps"),
    "step_order_error": (("step_scene", "integrator"), "1", "standard error of that order"),
    "peer": (("peer",), None, "program"),
    "peer_scene": (("peer_scene",), None, "what the programs run, at the steps of the same scene above"),
    "peer_error": (("peer_scene", "peer", "step_level"), "1", "rms error as above, against the program's own reference"),
    "peer_time": (("peer_scene", "peer", "step_level", "step_repeat"), "s", "processor time of one collision, or of the run of a bed"),
    "peer_order": (("peer_scene", "peer"), "1", "order of convergence of the error, fitted to the smallest steps"),
}  # fmt: skip
DRAG = {
    "trial_shape": (("trial",), None, "label of the shape"),
    "trial_seed": (("trial",), "1", "seed of the bed"),
    "trial_fraction": (("trial",), "1", "step fraction"),
    "trial_drag": (("trial",), "N", "mean drag within the averaging window, NaN where the run failed"),
    "trial_time_step": (("trial",), "s", "mean time step of the run, NaN where it failed"),
    "trial_time": (("trial",), "s", "processor time of the run"),
    "trial_status": (("trial",), None, "ran, or the name of the error that stopped the run"),
    "replicate": (("replicate",), "1", "seed of the bed"),
    "replicate_displacement": (("replicate_displacement",), "m", "displacement of the cylinder, middle of the bin"),
    "replicate_drag": (("replicate", "replicate_displacement"), "N", "drag: mean force on the cylinder against its motion over the bin"),
    "replicate_time": (("replicate",), "s", "processor time of the run, over the whole stroke"),
}  # fmt: skip
VARIABLES = CONTACTS | STEPS | DRAG
