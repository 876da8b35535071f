"""vasowave: from one animal's vessels and one catheter recording to a calibrated, explained pulse-wave model."""
