// Upper half of a Kalthoff-Winkler plate, 100 x 100 mm: a slit of 50 mm from the left, 25 mm above the plane of symmetry, of
// a width of its own. Triangles, fine where the crack may run.
DefineConstant[
  h = 1, far = 3, // sizes of cells, mm
  width = 0.3     // of the slit
];
lip = width / 2;
Point(1) = {0, 0, 0}; Point(2) = {100, 0, 0}; Point(3) = {100, 100, 0}; Point(4) = {0, 100, 0};
Point(5) = {0, 25 + lip, 0}; Point(6) = {50, 25 + lip, 0}; Point(7) = {50, 25 - lip, 0}; Point(8) = {0, 25 - lip, 0};
For i In {1 : 8}
  Line(i) = {i, i % 8 + 1};
EndFor
Curve Loop(1) = {1 : 8};
Plane Surface(1) = {1};
Field[1] = Box;
Field[1].XMin = 40; Field[1].XMax = 100; Field[1].YMin = 20; Field[1].YMax = 100;
Field[1].VIn = h; Field[1].VOut = far; Field[1].Thickness = 15;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("plate") = {1};
Physical Curve("symmetry") = {1};
Physical Curve("hit") = {8}; // below the slit
