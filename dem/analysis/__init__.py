"""What is asked of combined runs: statistics, tables, how beds flow.

In: datasets. Out: numbers with their uncertainty, as datasets and tables; draws nothing.
"""

import lazy_loader

__getattr__ = lazy_loader.attach(__name__, ["rft"])[0]  # dem.rft of ../__init__.pyi
