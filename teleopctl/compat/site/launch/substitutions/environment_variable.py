"""``launch.substitutions.environment_variable``."""

from ..frontend.expose import expose_substitution
from ..substitution import in_words
from ._with_default import WithDefault


@expose_substitution("env")
class EnvironmentVariable(WithDefault):
    """The value of an environment variable, as the processes see it."""

    name_in_texts = "env"

    def describe(self) -> str:
        """Return it in words."""
        return f"EnvVar({in_words(self._name)})"
