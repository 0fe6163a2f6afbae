// A box with one region "solid" and its sides, in 2D or 3D, of any shape of cell.
// Sides: left, right (x), bottom, top (y), back, front (z); point "origin".
DefineConstant[
  dim = 2,      // 2 or 3
  simplex = 0,  // 0: quadrilaterals or hexahedra, 1: triangles or tetrahedra
  lx = 1, ly = 1, lz = 1,
  n = 4,        // cells along x
  ny = n, nz = n
];
For k In {0 : dim - 2}
  Point(4 * k + 1) = {0, 0, k * lz};
  Point(4 * k + 2) = {lx, 0, k * lz};
  Point(4 * k + 3) = {lx, ly, k * lz};
  Point(4 * k + 4) = {0, ly, k * lz};
  Line(4 * k + 1) = {4 * k + 1, 4 * k + 2};
  Line(4 * k + 2) = {4 * k + 2, 4 * k + 3};
  Line(4 * k + 3) = {4 * k + 3, 4 * k + 4};
  Line(4 * k + 4) = {4 * k + 4, 4 * k + 1};
  Curve Loop(k + 1) = {4 * k + 1, 4 * k + 2, 4 * k + 3, 4 * k + 4};
  Plane Surface(k + 1) = {k + 1};
  Transfinite Curve {4 * k + 1, 4 * k + 3} = n + 1;
  Transfinite Curve {4 * k + 2, 4 * k + 4} = ny + 1;
EndFor
Physical Point("origin") = {1};
If (dim == 2)
  Physical Surface("solid") = {1};
  Physical Curve("bottom") = {1};
  Physical Curve("right") = {2};
  Physical Curve("top") = {3};
  Physical Curve("left") = {4};
Else
  For k In {1 : 4}
    Line(8 + k) = {k, 4 + k};
    Transfinite Curve {8 + k} = nz + 1;
  EndFor
  For k In {1 : 4}
    Curve Loop(2 + k) = {k, 9 + (k % 4), -(4 + k), -(8 + k)};
    Plane Surface(2 + k) = {2 + k};
  EndFor
  Surface Loop(1) = {1 : 6};
  Volume(1) = {1};
  Physical Volume("solid") = {1};
  Physical Surface("back") = {1};
  Physical Surface("front") = {2};
  Physical Surface("bottom") = {3};
  Physical Surface("right") = {4};
  Physical Surface("top") = {5};
  Physical Surface("left") = {6};
EndIf
// Tetrahedra are left unstructured: a regular grid of points would give flat ones.
If (dim == 2 || simplex == 0)
  Transfinite Surface "*";
EndIf
If (simplex == 0)
  Recombine Surface "*";
  If (dim == 3)
    Transfinite Volume {1};
  EndIf
EndIf
