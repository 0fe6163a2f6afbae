"""A block pressed between frictionless plates: the closed form of the elastic law without damage."""


def press(E, nu, b, dim=2):
    """Lateral stretch that leaves no lateral stress at the stretch b along the press, and the force per reference width
    or area that the plates carry then: first Piola stress of F = diag(a, b, 1) (plane strain) or diag(a, b, a) (dim 3),
    K/2 [(J^2 - 1)/2 - ln J] + G/2 (J^(-2/3) tr C - 3)."""
    K, G = E / (3 * (1 - 2 * nu)), E / (2 * (1 + nu))

    def stress(a):
        c = 1 if dim == 2 else a
        J = a * b * c
        volume, trace = K / 2 * (J - 1 / J), a * a + b * b + c * c
        return [volume * J / x + G * J ** (-2 / 3) * (x - trace / (3 * x)) for x in (a, b)]

    low, high = 1.0, 1.1
    for _ in range(200):
        a = (low + high) / 2
        low, high = (a, high) if stress(a)[0] < 0 else (low, a)
    return a, -stress(a)[1]
