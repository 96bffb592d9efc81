"""The threads that run dem.dynamics.integration.advance together."""

from concurrent.futures import ThreadPoolExecutor

from dem.dynamics.integration import advance
from dem.jit.lanes import make_lanes
from dem.dynamics.synchronise import make_teams


class Crew:
    """A number of threads, each with a place in the team and scratch lanes of its own."""

    def __init__(self, threads: int):
        self._teams = make_teams(threads)
        self._lanes = [make_lanes() for _ in range(threads)]
        self._pool = ThreadPoolExecutor(threads)

    def advance(self, world, dt, steps, room):
        """As dem.dynamics.integration.advance, with the same result for any number of threads."""
        runs = [
            self._pool.submit(advance, world._replace(lanes=lanes), dt, steps, room, team)
            for team, lanes in zip(self._teams, self._lanes, strict=True)
        ]
        results = [run.result() for run in runs]
        return results[0]
