"""Sweeps on executors: any of concurrent.futures, and the workers of a Dask cluster."""

import os
import subprocess
import sys
import time
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
import yaml
from conftest import posix
from made import smoke

import dem
from dem.base.errors import InputError, RunError
from dem.sweep import batch as making
from dem.sweep import cluster, workers
from dem.sweep.campaign import Campaign
