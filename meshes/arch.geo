// An arch, more than half of a circle about the origin: hinged at its left end, clamped at its right one, with its crown at the top.
DefineConstant[
  R = 100,       // of its middle line
  h = 0.5,       // height of its section
  half = 107.5,  // degrees from the crown to an end
  n = 240,       // cells along it
  nh = 2         // across it
];
Point(1) = {0, 0, 0};
For i In {0 : 2} // hinge, crown, clamp
  b = Pi / 2 + half * Pi / 180 * (1 - i);
  For k In {0 : 2}
    r = R + h * (k - 1) / 2;
    Point(10 * i + k + 2) = {r * Cos(b), r * Sin(b), 0};
  EndFor
  Line(2 * i + 1) = {10 * i + 2, 10 * i + 3};
  Line(2 * i + 2) = {10 * i + 3, 10 * i + 4};
EndFor
Transfinite Curve {1 : 6} = nh / 2 + 1;
For i In {0 : 1}
  Circle(11 + i) = {10 * i + 2, 1, 10 * i + 12};
  Circle(13 + i) = {10 * i + 4, 1, 10 * i + 14};
  Transfinite Curve {11 + i, 13 + i} = n / 2 + 1;
  Curve Loop(i + 1) = {11 + i, 2 * i + 3, 2 * i + 4, -(13 + i), -(2 * i + 2), -(2 * i + 1)};
  Plane Surface(i + 1) = {i + 1};
  Transfinite Surface {i + 1} = {10 * i + 2, 10 * i + 12, 10 * i + 14, 10 * i + 4};
EndFor
Recombine Surface {1, 2};
Physical Surface("arch") = {1, 2};
Physical Point("hinge") = {3};
Physical Point("crown") = {13};
Physical Curve("clamp") = {5, 6};
