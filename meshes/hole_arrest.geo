// A plate, 140 x 70 mm, with two holes: from the left one, 30 mm wide, a notch runs 15 mm to the right; the other one, 23 mm
// wide, lies above the way of the crack. Squares of the size h along that way, triangles elsewhere, which grow away from it.
DefineConstant[
  h = 0.0375,
  band = 1.5, // height of the band of squares
  last = 94,  // where it ends
  far = 2   // size of the largest cells
];
tip = 75; lip = 0.25; dx = Sqrt(15 ^ 2 - lip ^ 2);
n = Round((last - tip) / h); across = Round(2 * lip / h); beside = Round((band / 2 - lip) / h);
Point(1) = {0, 0, 0}; Point(2) = {140, 0, 0}; Point(3) = {140, 70, 0}; Point(4) = {0, 70, 0};
Point(10) = {45, 35, 0}; Point(11) = {45 + dx, 35 - lip, 0}; Point(12) = {45 + dx, 35 + lip, 0};
Point(13) = {45, 50, 0}; Point(14) = {30, 35, 0}; Point(15) = {45, 20, 0};
Point(20) = {90, 50, 0}; Point(21) = {101.5, 50, 0}; Point(22) = {90, 61.5, 0}; Point(23) = {78.5, 50, 0}; Point(24) = {90, 38.5, 0};
Point(30) = {tip, 35 - band / 2, 0}; Point(31) = {tip, 35 - lip, 0}; Point(32) = {tip, 35 + lip, 0}; Point(33) = {tip, 35 + band / 2, 0};
Point(34) = {last, 35 - band / 2, 0}; Point(35) = {last, 35 - lip, 0}; Point(36) = {last, 35 + lip, 0}; Point(37) = {last, 35 + band / 2, 0};
For i In {1 : 4}
  Line(i) = {i, i % 4 + 1};
EndFor
Circle(11) = {12, 10, 13}; Circle(12) = {13, 10, 14}; Circle(13) = {14, 10, 15}; Circle(14) = {15, 10, 11};
Line(15) = {11, 31}; Line(16) = {32, 12};
For i In {0 : 3}
  Circle(21 + i) = {21 + i, 20, 21 + (i + 1) % 4};
EndFor
For i In {0 : 2} // upwards on both sides of the band
  Line(31 + i) = {30 + i, 31 + i}; Line(35 + i) = {34 + i, 35 + i};
EndFor
For i In {0 : 3} // along it
  Line(41 + i) = {30 + i, 34 + i};
EndFor
Curve Loop(1) = {1 : 4};
Curve Loop(2) = {11 : 14, 15, -31, 41, 35, 36, 37, -44, -33, 16};
Curve Loop(3) = {21 : 24};
Plane Surface(1) = {1, 2, 3};
For i In {0 : 2}
  Curve Loop(11 + i) = {41 + i, 35 + i, -(42 + i), -(31 + i)}; Plane Surface(11 + i) = {11 + i};
EndFor
Transfinite Curve {41 : 44} = n + 1;
Transfinite Curve {31, 33, 35, 37} = beside + 1;
Transfinite Curve {32, 36} = across + 1;
Transfinite Surface {11 : 13}; Recombine Surface {11 : 13};
Field[1] = Distance; Field[1].CurvesList = {31, 33, 35, 36, 37, 41, 44}; Field[1].NumPointsPerCurve = 400;
Field[2] = MathEval; Field[2].F = Sprintf("Min(%g + 0.25 * F1, %g)", h, far);
Background Field = 2;
Mesh.MeshSizeExtendFromBoundary = 0;
Mesh.MeshSizeFromPoints = 0;
Mesh.Algorithm = 6;
Mesh.Smoothing = 20;
Physical Surface("plate") = {1, 11 : 13};
Physical Curve("struck") = {4}; Physical Curve("held") = {2};
