// A belt around the upper half of a drum of the given radius about the origin, and straight down on both sides.
DefineConstant[
  radius = 50, thickness = 0.5, tail = 20,
  n = 90,      // cells along a quarter of the circle
  n_across = 2,
  n_tail = 20
];
Point(1) = {0, 0, 0};
For k In {0 : 1} // inside, outside
  r = radius + k * thickness;
  f = 10 * (k + 1);
  Point(f) = {r, -tail, 0};
  Point(f + 1) = {r, 0, 0};
  Point(f + 2) = {0, r, 0};
  Point(f + 3) = {-r, 0, 0};
  Point(f + 4) = {-r, -tail, 0};
  Line(f) = {f, f + 1};
  Circle(f + 1) = {f + 1, 1, f + 2};
  Circle(f + 2) = {f + 2, 1, f + 3};
  Line(f + 3) = {f + 3, f + 4};
EndFor
For i In {0 : 4}
  Line(30 + i) = {10 + i, 20 + i};
EndFor
For i In {0 : 3}
  Curve Loop(i + 1) = {-(10 + i), 30 + i, 20 + i, -(31 + i)};
  Plane Surface(i + 1) = {i + 1};
EndFor
Transfinite Curve {10, 13, 20, 23} = n_tail + 1;
Transfinite Curve {11, 12, 21, 22} = n + 1;
Transfinite Curve {30 : 34} = n_across + 1;
Transfinite Surface {1 : 4};
Recombine Surface {1 : 4};
Physical Surface("belt") = {1 : 4};
Physical Curve("inside") = {10 : 13};
Physical Curve("slack") = {30};
Physical Curve("tight") = {34};
