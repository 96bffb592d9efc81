"""The layout of verification.nc, as in dem.io.dataset."""

# name: (dimensions, units, long name)
VARIABLES = {
    "case": (("case",), None, "case: its file in studies/verification/cases"),
    "case_title": (("case",), None, "what the case is about"),
    "case_source": (("case",), None, "where what is expected comes from"),
    "case_time": (("case",), "s", "time that the case took, with compiling where it was the first"),
    "row_case": (("row",), None, "case that the number belongs to"),
    "row_name": (("row",), None, "what the number is"),
    "row_units": (("row",), None, "units of the number"),
    "row_x": (("row",), "1", "abscissa of the number in the figure, NaN where it has none"),
    "row_value": (("row",), "1", "what came out, in row_units"),
    "row_expected": (("row",), "1", "what is expected, in row_units"),
    "row_tolerance": (("row",), "1", "how far the value may be from what is expected, in row_units"),
    "row_passed": (("row",), "1", "1 where the value is within the tolerance"),
}  # fmt: skip
