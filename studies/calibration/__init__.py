"""Which Young's modulus gives the paper's drag of discs?"""
