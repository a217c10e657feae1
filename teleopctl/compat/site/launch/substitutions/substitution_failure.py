"""``launch.substitutions.substitution_failure``."""


class SubstitutionFailure(RuntimeError):
    """Raised when a substitution cannot be evaluated."""
