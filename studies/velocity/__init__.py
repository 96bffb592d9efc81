"""Is the drag at the paper's velocity quasi-static?"""
