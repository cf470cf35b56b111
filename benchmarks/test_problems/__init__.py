"""Problems that only the suite uses."""
