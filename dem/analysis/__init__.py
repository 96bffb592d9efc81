"""What is asked of combined runs: statistics, tables, how beds flow.

In: datasets. Out: numbers with their uncertainty, as datasets and tables; draws nothing.
"""
