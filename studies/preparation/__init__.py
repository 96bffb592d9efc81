"""Does the drag depend on how a bed was made?"""
