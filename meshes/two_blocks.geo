// Two unit blocks one above the other, whose meshes do not match at the interface y = 1 (before the rotation).
// No extrusion: it would merge the two sides of the interface.
DefineConstant[
  dim = 2,      // 2 or 3
  n_lower = 4, n_upper = 3,
  gap = 0,
  inset = 0,    // the upper block is narrower by this on each side
  angle = 0,    // degrees: both blocks turned about the origin in the plane of x and y
  tilt = 0,     // degrees: in space, and then in the plane of y and z
  simplices_lower = 0, simplices_upper = 0 // 1: triangles or tetrahedra; 2: their diagonals
                // on upper_bottom are those on lower_top
];
turn = angle * Pi / 180;
lean = tilt * Pi / 180;
x[] = {0, 1, 1, 0, inset, 1 - inset, 1 - inset, inset};
y[] = {0, 0, 1, 1, 1 + gap, 1 + gap, 2 + gap, 2 + gap};
z[] = {0, 1, inset, 1 - inset};
n[] = {n_lower, n_upper};
For b In {0 : 1}
  f = 100 * b; // numbers of this block start here
  For k In {0 : dim - 2}
    For i In {0 : 3}
      up = Sin(turn) * x[4 * b + i] + Cos(turn) * y[4 * b + i];
      aside = (dim - 2) * z[2 * b + k];
      Point(f + 4 * k + i + 1) = {Cos(turn) * x[4 * b + i] - Sin(turn) * y[4 * b + i],
                                  Cos(lean) * up - Sin(lean) * aside, Sin(lean) * up + Cos(lean) * aside};
    EndFor
    For i In {1 : 4}
      Line(f + 4 * k + i) = {f + 4 * k + i, f + 4 * k + 1 + (i % 4)};
    EndFor
    Curve Loop(f + k + 1) = {f + 4 * k + 1 : f + 4 * k + 4};
    Plane Surface(f + k + 1) = {f + k + 1};
  EndFor
  Transfinite Curve {f + 1 : f + 4 * (dim - 1)} = n[b] + 1;
  If (dim == 3)
    For i In {1 : 4}
      Line(f + 8 + i) = {f + i, f + 4 + i};
      Transfinite Curve {f + 8 + i} = n[b] + 1;
    EndFor
    For i In {1 : 4}
      Curve Loop(f + 2 + i) = {f + i, f + 9 + (i % 4), -(f + 4 + i), -(f + 8 + i)};
      Plane Surface(f + 2 + i) = {f + 2 + i};
    EndFor
    Surface Loop(f + 1) = {f + 1 : f + 6};
    Volume(f + 1) = {f + 1};
  EndIf
EndFor
Transfinite Surface "*";
If (dim == 3 && simplices_upper == 2)
  Transfinite Surface {103} Right;
EndIf
simplices[] = {simplices_lower, simplices_upper};
For b In {0 : 1}
  If (simplices[b] == 0)
    If (dim == 2)
      Recombine Surface {100 * b + 1};
    Else
      Recombine Surface {100 * b + 1 : 100 * b + 6};
      Transfinite Volume {100 * b + 1};
    EndIf
  EndIf
EndFor
If (dim == 2)
  Physical Surface("lower") = {1};
  Physical Curve("lower_bottom") = {1};
  Physical Curve("lower_top") = {3};
  Physical Curve("lower_sides") = {2, 4};
  Physical Surface("upper") = {101};
  Physical Curve("upper_bottom") = {101};
  Physical Curve("upper_top") = {103};
  Physical Curve("upper_sides") = {102, 104};
Else
  Physical Volume("lower") = {1};
  Physical Surface("lower_bottom") = {3};
  Physical Surface("lower_top") = {5};
  Physical Surface("lower_sides") = {1, 2, 4, 6};
  Physical Volume("upper") = {101};
  Physical Surface("upper_bottom") = {103};
  Physical Surface("upper_top") = {105};
  Physical Surface("upper_sides") = {101, 102, 104, 106};
EndIf
