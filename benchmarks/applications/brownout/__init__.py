"""A stated model of a brownout cloud: emission by the wind, flights, optical depth."""
