"""What does a budget of processor time buy: which step, box, stroke and number of beds?"""
