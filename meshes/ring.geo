// Half of a slightly oval ring, x >= 0, cut at x = 0, in the plane or in space. Its mid-line has the half axes radius (1 + oval), radius (1 - oval).
DefineConstant[
  radius = 10, thickness = 0.5, oval = 0.005,
  n_around = 250,   // cells along the half ring
  n_through = 2,
  simplices = 0,    // 1: triangles
  width = 0,        // in space, hexahedra: along z, on n_wide cells
  n_wide = 1,
  angle = 0         // degrees: the ring turned about the origin
];
turn = angle * Pi / 180;
c = Cos(turn); s = Sin(turn);
Point(1) = {0, 0, 0};
For k In {0 : 1}
  a = radius * (1 + oval) + (k - 0.5) * thickness;
  b = radius * (1 - oval) + (k - 0.5) * thickness;
  f = 10 * (k + 1);
  Point(f) = {s * b, -c * b, 0};
  Point(f + 1) = {c * a, s * a, 0};
  Point(f + 2) = {-s * b, c * b, 0};
  Ellipse(f) = {f, 1, f + 1, f + 1};
  Ellipse(f + 1) = {f + 1, 1, f + 1, f + 2};
  Transfinite Curve {f, f + 1} = n_around / 2 + 1;
EndFor
For i In {0 : 2}
  Line(30 + i) = {10 + i, 20 + i};
  Transfinite Curve {30 + i} = n_through + 1;
EndFor
For i In {0 : 1}
  Curve Loop(1 + i) = {30 + i, 20 + i, -(31 + i), -(10 + i)};
  Plane Surface(1 + i) = {1 + i};
EndFor
Transfinite Surface {1, 2};
If (simplices == 0)
  Recombine Surface {1, 2};
EndIf
If (width == 0)
  Physical Surface("ring") = {1, 2};
  Physical Curve("inside") = {10, 11};
  Physical Curve("outside") = {20, 21};
  Physical Curve("cut") = {30, 32};
Else
  out[] = Extrude {0, 0, width} { Surface{1, 2}; Layers{n_wide}; Recombine; };
  // Of each surface: its copy, the volume, the sides over its curves.
  Physical Volume("ring") = {out[1], out[7]};
  Physical Surface("inside") = {out[5], out[11]};
  Physical Surface("outside") = {out[3], out[9]};
  Physical Surface("cut") = {out[2], out[10]};
  Physical Surface("faces") = {1, 2, out[0], out[6]};
EndIf
Physical Point("right") = {21};
Physical Point("top") = {12};
Physical Point("bottom") = {10};
