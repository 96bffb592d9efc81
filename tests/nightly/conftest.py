"""Tests that take hours: many more examples of hypothesis than the suite has."""

import hypothesis

hypothesis.settings.load_profile("night")
