"""``launch.substitutions.substitution_failure``."""


class SubstitutionFailure(RuntimeError):
    """A substitution cannot be evaluated."""
