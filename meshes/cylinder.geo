// The section of a thick cylinder: a ring of triangles.
DefineConstant[
  inner = 80, outer = 150,
  h = 0.8 // size of cells
];
r[] = {inner, outer};
Point(1) = {0, 0, 0};
For i In {0 : 1}
  For k In {0 : 3}
    Point(10 * (i + 1) + k) = {r[i] * Cos(k * Pi / 2), r[i] * Sin(k * Pi / 2), 0};
  EndFor
  For k In {0 : 3}
    Circle(10 * (i + 1) + k) = {10 * (i + 1) + k, 1, 10 * (i + 1) + (k + 1) % 4};
  EndFor
  Curve Loop(i + 1) = {10 * (i + 1) : 10 * (i + 1) + 3};
EndFor
Plane Surface(1) = {2, 1};
Mesh.MeshSizeMin = h; Mesh.MeshSizeMax = h;
Physical Surface("cylinder") = {1};
Physical Curve("inside") = {10 : 13}; Physical Curve("outside") = {20 : 23};
