// A beam of 20 x 8 with a notch of depth 1 at x = 4 and three holes of the diameter 0.5 above one another at x = 6. Cells are h
// wide from the notch to beyond the second hole, where the crack runs, and half a unit elsewhere.
DefineConstant[
  h = 0.04
];
wide = 0.5; pad = 0.2; opening = 0.04;
Point(1) = {0, 0, 0, wide};
Point(2) = {0.9, 0, 0, pad};
Point(3) = {1.1, 0, 0, pad};
Point(4) = {4 - opening / 2, 0, 0, h};
Point(5) = {4, 1, 0, h};
Point(6) = {4 + opening / 2, 0, 0, h};
Point(7) = {18.9, 0, 0, pad};
Point(8) = {19.1, 0, 0, pad};
Point(9) = {20, 0, 0, wide};
Point(10) = {20, 8, 0, wide};
Point(11) = {10.1, 8, 0, pad};
Point(12) = {9.9, 8, 0, pad};
Point(13) = {0, 8, 0, wide};
For i In {1 : 12}
  Line(i) = {i, i + 1};
EndFor
Line(13) = {13, 1};
Curve Loop(1) = {1 : 13};
For i In {0 : 2}
  c = 100 + 10 * i;
  Point(c) = {6, 2.75 + 2 * i, 0};
  Point(c + 1) = {6.25, 2.75 + 2 * i, 0, 2 * h};
  Point(c + 2) = {5.75, 2.75 + 2 * i, 0, 2 * h};
  Circle(c) = {c + 1, c, c + 2};
  Circle(c + 1) = {c + 2, c, c + 1};
  Curve Loop(2 + i) = {c, c + 1};
EndFor
Plane Surface(1) = {1 : 4};
Field[1] = Box;
Field[1].XMin = 3.6; Field[1].XMax = 6.6;
Field[1].YMin = 0.8; Field[1].YMax = 5.2;
Field[1].VIn = h; Field[1].VOut = wide; Field[1].Thickness = 2;
Background Field = 1;
Mesh.Algorithm = 6;
Physical Surface("beam") = {1};
Physical Curve("left") = {2};
Physical Curve("right") = {7};
Physical Curve("load") = {11};
Physical Curve("first") = {100, 101};
Physical Curve("second") = {110, 111};
Physical Curve("third") = {120, 121};
