// The section of a rubber bush: a full ring of quadrilaterals or triangles, in space a length of it.
DefineConstant[
  inner = 1, outer = 2,
  n = 12,        // cells through the thickness, four quarters of twice as many around
  simplices = 0, // 1: triangles or tetrahedra
  length = 0,    // in space
  n_long = 1
];
r[] = {inner, outer};
Point(1) = {0, 0, 0};
For i In {0 : 1}
  For k In {0 : 3}
    Point(10 * (i + 1) + k) = {r[i] * Cos(k * Pi / 2), r[i] * Sin(k * Pi / 2), 0};
  EndFor
EndFor
For i In {0 : 1}
  For k In {0 : 3}
    Circle(10 * (i + 1) + k) = {10 * (i + 1) + k, 1, 10 * (i + 1) + (k + 1) % 4};
  EndFor
EndFor
For k In {0 : 3}
  Line(30 + k) = {10 + k, 20 + k};
EndFor
For k In {0 : 3}
  Curve Loop(k + 1) = {30 + k, 20 + k, -(30 + (k + 1) % 4), -(10 + k)};
  Plane Surface(k + 1) = {k + 1};
EndFor
Transfinite Curve {10 : 13, 20 : 23} = 2 * n + 1;
Transfinite Curve {30 : 33} = n + 1;
Transfinite Surface "*";
If (simplices == 0)
  Recombine Surface "*";
EndIf
If (length == 0)
  Physical Surface("bush") = {1 : 4};
  Physical Curve("inside") = {10 : 13}; Physical Curve("outside") = {20 : 23};
Else
  inside[] = {}; outside[] = {}; ends[] = {1 : 4}; bush[] = {};
  For k In {1 : 4}
    If (simplices == 0)
      o[] = Extrude {0, 0, length} { Surface{k}; Layers{n_long}; Recombine; };
    Else
      o[] = Extrude {0, 0, length} { Surface{k}; Layers{n_long}; };
    EndIf
    ends[] += o[0]; bush[] += o[1]; outside[] += o[3]; inside[] += o[5];
  EndFor
  Physical Volume("bush") = bush[];
  Physical Surface("inside") = inside[]; Physical Surface("outside") = outside[]; Physical Surface("ends") = ends[];
EndIf
