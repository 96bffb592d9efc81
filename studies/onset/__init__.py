"""Where do frictionless ellipses jam, and on how many contacts?"""
