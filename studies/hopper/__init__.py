"""How fast does a hopper empty, by the width of its orifice?"""
