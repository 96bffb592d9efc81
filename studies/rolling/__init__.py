"""Can rolling resistance stand in for the shape of granules?"""
