"""Do the results survive another contact law?"""
