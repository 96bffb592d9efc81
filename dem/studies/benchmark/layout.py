"""The layout of benchmark.nc, as in dem.io.dataset."""

# name: (dimensions, units, long name)
VARIABLES = {
    "scene": (("scene",), None, "granules of the bed that the codes run side by side"),
    "code": (("code",), None, "program"),
    "code_status": (("code",), None, "whether the program ran, or why not"),
    "granule_steps_per_second": (("scene", "code", "repeat"), "s-1", "granules times time steps over the time taken, on one core"),
    "time_per_contact": (("scene", "code"), "s", "median time of a step over the number of touching pairs of parts"),
    "scene_granules": (("scene",), "1", "number of granules"),
    "scene_contacts": (("scene",), "1", "number of touching pairs of parts of granules at the start"),
    "scene_pairs": (("scene",), "1", "number of pairs in our contact list at the start"),
    "scene_time_step": (("scene",), "s", "time step of all programs"),
    "variant": (("variant",), None, "what the scene holds"),
    "variant_step_time": (("variant", "repeat"), "s", "time of one step of one granule, contacts held as they are"),
    "variant_ratio": (("variant",), "1", "median of that time over that of the first scene"),
    "variant_code_size": (("variant",), "1", "bytes of machine code of one step with all that it calls"),
    "size": (("size",), "1", "number of discs of a bed of mirrored tiles, with friction and damping, without a cylinder"),
    "threads": (("threads",), "1", "number of threads"),
    "size_step_time": (("size", "threads", "repeat"), "s", "time of one step of one granule, contacts listed again as needed"),
    "size_memory": (("size",), "byte", "memory of all arrays of the kernels over the number of granules"),
    "comparison": (("comparison",), None, "undamped bed that two programs move from the same start"),
    "comparison_steps": (("comparison_steps",), "1", "time steps from the start"),
    "trajectory_difference": (("comparison", "comparison_steps"), "1", "greatest distance of a granule between LAMMPS and ours over the mean radius"),
}  # fmt: skip
