// A plate, 140 x 70 mm, with two holes: from the left one, 30 mm wide, a notch runs 15 mm to the right; the other one, 23 mm
// wide, lies above the way of the crack. The middle 40 mm of the left side are struck, those of the right side held.
// Triangles, of the size h along that way, and growing away from it.
DefineConstant[
  h = 0.05,
  low = 33.6, high = 35.2, last = 93, // up to where, from the end of the notch at x = 75, y = 35
  far = 2                             // size of the largest cells
];
tip = 75; lip = 0.25; dx = Sqrt(15 ^ 2 - lip ^ 2);
Point(1) = {0, 0, 0}; Point(2) = {140, 0, 0}; Point(3) = {140, 15, 0}; Point(4) = {140, 55, 0};
Point(5) = {140, 70, 0}; Point(6) = {0, 70, 0}; Point(7) = {0, 55, 0}; Point(8) = {0, 15, 0};
Point(10) = {45, 35, 0}; Point(11) = {45 + dx, 35 - lip, 0}; Point(12) = {tip, 35 - lip, 0}; Point(13) = {tip, 35 + lip, 0};
Point(14) = {45 + dx, 35 + lip, 0}; Point(15) = {45, 50, 0}; Point(16) = {30, 35, 0}; Point(17) = {45, 20, 0};
Point(20) = {90, 50, 0}; Point(21) = {101.5, 50, 0}; Point(22) = {90, 61.5, 0}; Point(23) = {78.5, 50, 0}; Point(24) = {90, 38.5, 0};
For i In {1 : 8}
  Line(i) = {i, i % 8 + 1};
EndFor
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14};
Circle(14) = {14, 10, 15}; Circle(15) = {15, 10, 16}; Circle(16) = {16, 10, 17}; Circle(17) = {17, 10, 11};
For i In {0 : 3}
  Circle(21 + i) = {21 + i, 20, 21 + (i + 1) % 4};
EndFor
Curve Loop(1) = {1 : 8}; Curve Loop(2) = {11 : 17}; Curve Loop(3) = {21 : 24};
Plane Surface(1) = {1, 2, 3};
Field[1] = MathEval; // grows with the distance from the box
Field[1].F = Sprintf("Min(%g + 0.25 * Sqrt(Max(0, Max(%g - x, x - %g))^2 + Max(0, Max(%g - y, y - %g))^2), %g)", h, tip - 0.3, last, low, high, far);
Background Field = 1;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;
Mesh.Smoothing = 10;
Physical Surface("plate") = {1};
Physical Curve("struck") = {7}; Physical Curve("held") = {3};
