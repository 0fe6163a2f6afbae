# labels: run long
# timeout: 600
"""Every method and enforcement of contact, in the plane and in space: free flight first, equal and opposite impulses, and
the same history turned about an axis of no edge with each body on a rank of its own."""
from _gates import ALL, flight, same, touches_and_keeps_momentum
from _runs import finish

for case in ALL:
    name = f"{case[0]}D, {case[1]}, {case[2]}"
    reference = flight(case, "straight")
    touches_and_keeps_momentum(name, reference)
    turned = flight(case, "turned", angle=37, tilt=-24 if case[0] == 3 else 0, ranks=2,
                    extra={"petscpartitioner_type": "simple"})
    same(f"{name}, turned, each body on its own rank", reference, turned, 1e-8)
finish()
