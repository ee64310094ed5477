"""What tools/mesh2data and tools/layers2data are made of."""
