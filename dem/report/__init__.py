"""One page that opens without a network: figures, tables, the drag to play with, the beds beside it."""
