"""Groups of animals: who belongs to which, described, compared, and the one of each that is shown."""
