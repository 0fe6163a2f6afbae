"""The notched beam (meshes/bend_beam.geo, options/notched_beam.opts) by linear fracture mechanics: three-point bending of a span of
four heights, K of ASTM E399, the deflection by its energy and the theory of beams with shear."""
import numpy

E, NU, SPAN, HEIGHT = 3000.0, 0.35, 80.0, 20.0  # MPa, mm
STIFF = E / (1 - NU**2)


def intensity(a):
    """K over force by thickness: a numpy array of crack lengths, mm."""
    r = a / HEIGHT
    f = 3 * numpy.sqrt(r) / (2 * (1 + 2 * r) * (1 - r)**1.5) * (1.99 - r * (1 - r) * (2.15 - 3.93 * r + 2.7 * r**2))
    return SPAN / HEIGHT**1.5 * f


def compliance(a):
    """Deflection over force by thickness."""
    r, slender = a / HEIGHT, HEIGHT / SPAN
    whole = SPAN**3 / (4 * STIFF * HEIGHT**3) * (1 + 2.85 * slender**2 - 0.84 * slender**3)
    cracks = numpy.linspace(0, numpy.max(a), 4001)
    release = 2 * intensity(cracks)**2 / STIFF  # twice G over the square of the force
    grown = numpy.concatenate([[0], numpy.cumsum((release[1:] + release[:-1]) / 2 * numpy.diff(cracks))])
    return whole + numpy.interp(a, cracks, grown)


def curve(a, toughness):
    """Deflection and force by thickness at which a crack of the length a grows."""
    force = numpy.sqrt(toughness * STIFF) / intensity(a)
    return force * compliance(a), force
