"""The layout of the study of time steps, as in dem.io.dataset."""

# name: (dimensions, units, long name)
VARIABLES = {
    "step_scene": (("step_scene",), None, "what is integrated"),
    "integrator": (("integrator",), None, "time integrator"),
    "step_default": ((), "1", "time step over the critical one that a simulation takes unless told"),
    "step_critical": (("step_scene",), "s", "lower bound of the critical time step"),
    "step_contact_time": (("step_scene",), "s", "duration of an elastic head-on collision of like discs at that speed"),
    "step_fraction": (("step_scene", "step_level"), "1", "time step over the critical one"),
    "step_error": (("step_scene", "integrator", "step_level"), "1", "rms error: of velocities after a collision over the speed of impact, of displacements in a bed over that of the cylinder"),
    "step_impulse_error": (("step_scene", "integrator", "step_level"), "1", "error of the impulse on the cylinder over that impulse"),
    "step_time": (("step_scene", "integrator", "step_level", "step_repeat"), "s", "processor time of one collision, or of the run of a bed"),
    "step_order": (("step_scene", "integrator"), "1", "order of convergence of the error, fitted to the smallest steps"),
    "step_order_error": (("step_scene", "integrator"), "1", "standard error of that order"),
    "step_impulse_order": (("step_scene", "integrator"), "1", "order of convergence of the impulse on the cylinder"),
    "step_reference_error": (("step_scene",), "1", "rms difference between the reference and one at twice its step"),
    "peer": (("peer",), None, "program"),
    "peer_status": (("peer",), None, "whether the program ran, or why not"),
    "peer_scene": (("peer_scene",), None, "what the programs run, at the steps of the same scene above"),
    "peer_error": (("peer_scene", "peer", "step_level"), "1", "rms error as above, against the program's own reference"),
    "peer_time": (("peer_scene", "peer", "step_level", "step_repeat"), "s", "processor time of one collision, or of the run of a bed"),
    "peer_order": (("peer_scene", "peer"), "1", "order of convergence of the error, fitted to the smallest steps"),
    "peer_reference_error": (("peer_scene", "peer"), "1", "rms difference between the reference and one at twice its step"),
    "peer_difference": (("peer_scene",), "1", "rms difference between the references of the two programs, where no exact values are known"),
}  # fmt: skip
