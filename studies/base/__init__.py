"""Does friction with a plate below a bed give the drag a yield force?"""
