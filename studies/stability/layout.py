"""The layout of stability.nc, as in dem.io.dataset."""

MAP = ("map_shape", "map_stiffness", "map_restitution", "map_fraction")

# name: (dimensions, units, long name)
VARIABLES = {
    "check_case": (("check",), None, "case of the catalogue"),
    "check_shape": (("check",), None, "label of the shape"),
    "check_quantity": (("check",), None, "what is limited"),
    "check_value": (("check",), "1", "worst value along the run, NaN where the case was refused"),
    "check_limit": (("check",), "1", "limit; NaN where the case must be refused"),
    "check_expected": (("check",), None, "ran, or the error that should refuse the case"),
    "check_outcome": (("check",), None, "ran, or the error that refused the case"),
    "check_message": (("check",), None, "what that error said"),
    "check_known": (("check",), None, "why the case is known to exceed a limit, if it is"),
    "check_passed": (("check",), "1", "1 where the outcome is the expected one and the value within the limit"),
    "map_shape": (("map_shape",), None, "label of the shape"),
    "map_stiffness": (("map_stiffness",), "1", "Young's modulus over that of the configuration"),
    "map_restitution": (("map_restitution",), "1", "coefficient of restitution"),
    "map_fraction": (("map_fraction",), "1", "time step over the bound of the critical one"),
    "map_residual": (MAP, "1", "worst residual of the energy ledger, NaN where the run failed"),
    "limit_shape": (("limit_shape",), None, "label of the shape, small bed"),
    "limit_bound": (("limit_shape",), "s", "bound of the critical time step"),
    "limit_limit": (("limit_shape",), "s", "time step at which the linearised bed begins to grow"),
    "paper_case": (("paper_case",), None, "case of the sweep, first seed, default step"),
    "paper_displacement": (("paper_displacement",), "m", "displacement of the cylinder"),
    "paper_residual": (("paper_case", "paper_displacement"), "1", "residual of the energy ledger"),
}  # fmt: skip
