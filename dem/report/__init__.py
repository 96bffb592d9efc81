"""One page that opens without a network, and tables for the terminal."""
