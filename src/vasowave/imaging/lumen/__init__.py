"""Which voxels are vessel."""
