"""Settings for the whole test suite."""

from hypothesis import settings

# The first call of a kernel compiles it, which no deadline of an example should count.
settings.register_profile("galvi", deadline=None, max_examples=40, derandomize=True)
settings.load_profile("galvi")
