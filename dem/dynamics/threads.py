"""The threads that run dem.dynamics.integration.advance together."""

from concurrent.futures import ThreadPoolExecutor

from dem.dynamics.integration import advance
from dem.dynamics.synchronise import make_threads
from dem.jit.lanes import make_lanes


class Threads:
    """A number of threads, each with its own place and scratch lanes."""

    def __init__(self, threads: int):
        self._places = make_threads(threads)
        self._lanes = [make_lanes() for _ in range(threads)]
        self._pool = ThreadPoolExecutor(threads)

    def advance(self, world, dt, steps, rebuild_at):
        """As dem.dynamics.integration.advance, with the same result for any number of threads."""
        runs = [
            self._pool.submit(advance, world._replace(lanes=lanes), dt, steps, rebuild_at, thread)
            for thread, lanes in zip(self._places, self._lanes, strict=True)
        ]
        results = [run.result() for run in runs]
        return results[0]
