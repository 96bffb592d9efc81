"""Do coefficients of resistive force theory, measured in grains, give the force on any outline?"""
