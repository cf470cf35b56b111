"""Problems with a solution in closed form."""
