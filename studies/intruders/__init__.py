"""What forces do intruders of other outlines, and pairs of cylinders, feel?"""
