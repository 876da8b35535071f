"""From a micro-CT volume to a vessel network: volume, segmentation, centerlines, tree."""
