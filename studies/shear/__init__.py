"""What friction and packing fraction does a sheared bed have?"""
