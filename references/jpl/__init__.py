"""JPL's DE421 ephemeris."""
