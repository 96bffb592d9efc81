"""What several studies use: other codes to compare with, timing, how findings become text."""
