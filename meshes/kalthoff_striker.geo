// Upper half of a Kalthoff-Winkler plate, 100 x 100 mm, and of the projectile that hits it below the slit: 100 mm long, of
// half the width of the slit's distance. The slit, 50 mm from the left and 25 mm above the plane of symmetry, has a width of
// its own. Triangles, fine where the crack may run.
DefineConstant[
  h = 1, far = 3, // sizes of cells, mm
  width = 0.3,    // of the slit
  length = 100,   // of the projectile
  gap = 0.01      // before it
];
lip = width / 2;
Point(1) = {0, 0, 0}; Point(2) = {100, 0, 0}; Point(3) = {100, 100, 0}; Point(4) = {0, 100, 0};
Point(5) = {0, 25 + lip, 0}; Point(6) = {50, 25 + lip, 0}; Point(7) = {50, 25 - lip, 0}; Point(8) = {0, 25 - lip, 0};
For i In {1 : 8}
  Line(i) = {i, i % 8 + 1};
EndFor
Curve Loop(1) = {1 : 8};
Plane Surface(1) = {1};
Point(11) = {-gap - length, 0, 0}; Point(12) = {-gap, 0, 0}; Point(13) = {-gap, 25 - lip, 0}; Point(14) = {-gap - length, 25 - lip, 0};
For i In {1 : 4}
  Line(10 + i) = {10 + i, 10 + i % 4 + 1};
EndFor
Curve Loop(2) = {11 : 14};
Plane Surface(2) = {2};
Field[1] = Box;
Field[1].XMin = 40; Field[1].XMax = 100; Field[1].YMin = 20; Field[1].YMax = 100;
Field[1].VIn = h; Field[1].VOut = far; Field[1].Thickness = 15;
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Physical Surface("plate") = {1};
Physical Surface("striker") = {2};
Physical Curve("symmetry") = {1, 11};
Physical Curve("hit") = {8}; // below the slit
Physical Curve("front") = {12};
