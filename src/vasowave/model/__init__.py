"""The model of an animal: walls, blood, outlets of a network, and their linear theory and first estimate."""
