"""Problems used only by the suite."""
