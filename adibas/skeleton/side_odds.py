"""How far the shape alone is believed about which way a patient faces."""


def side_factor(one_way: float, other_way: float, divisor: float) -> float:
    """Return by what the weights of the other way are multiplied to divide its log odds.

    Parameters
    ----------
    one_way, other_way : float
        Sums of the weights of all names of which a patient faces one way, and the other. That there
        are many of them must not make them more probable, so that their sums are compared.
    """
    if other_way <= 0.0:
        return 1.0
    return float((other_way / one_way) ** (1.0 / divisor - 1.0))
