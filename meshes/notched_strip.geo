// A rectangle with a notch of the width `notch` from the middle of its left side, in quadrilaterals: squares to the right
// of the notch's end, longer ones beside it.
DefineConstant[
  width = 100, height = 40,
  slit = 50,    // length of the notch
  notch = 0.5,  // its width
  n = 400,      // squares that the width would take
  beside = 60   // cells along the notch
];
h = width / n;
rows = Round((height - notch) / (2 * h)); ahead = Round((width - slit) / h); across = Round(notch / h);
low = (height - notch) / 2; high = (height + notch) / 2;
Point(1) = {0, 0, 0}; Point(2) = {slit, 0, 0}; Point(3) = {width, 0, 0};
Point(4) = {0, low, 0}; Point(5) = {slit, low, 0}; Point(6) = {width, low, 0};
Point(7) = {0, high, 0}; Point(8) = {slit, high, 0}; Point(9) = {width, high, 0};
Point(10) = {0, height, 0}; Point(11) = {slit, height, 0}; Point(12) = {width, height, 0};
Line(1) = {2, 1}; Line(2) = {5, 4}; Line(3) = {8, 7}; Line(4) = {11, 10};
Line(5) = {2, 3}; Line(6) = {5, 6}; Line(7) = {8, 9}; Line(8) = {11, 12};
Line(9) = {1, 4}; Line(10) = {2, 5}; Line(11) = {3, 6};
Line(12) = {5, 8}; Line(13) = {6, 9};
Line(14) = {7, 10}; Line(15) = {8, 11}; Line(16) = {9, 12};
Curve Loop(1) = {-1, 10, 2, -9}; Plane Surface(1) = {1};
Curve Loop(2) = {5, 11, -6, -10}; Plane Surface(2) = {2};
Curve Loop(3) = {6, 13, -7, -12}; Plane Surface(3) = {3};
Curve Loop(4) = {-3, 15, 4, -14}; Plane Surface(4) = {4};
Curve Loop(5) = {7, 16, -8, -15}; Plane Surface(5) = {5};
grow = 1.1; // that of cells which begin with h
For i In {1 : 20}
  grow = grow - (h * (grow ^ beside - 1) / (grow - 1) - slit) / (h * (beside * grow ^ (beside - 1) * (grow - 1) - (grow ^ beside - 1)) / (grow - 1) ^ 2);
EndFor
Transfinite Curve {1, 2, 3, 4} = beside + 1 Using Progression grow;
Transfinite Curve {5, 6, 7, 8} = ahead + 1;
Transfinite Curve {9, 10, 11, 14, 15, 16} = rows + 1;
Transfinite Curve {12, 13} = across + 1;
Transfinite Surface {1 : 5};
Recombine Surface {1 : 5};
Physical Surface("plate") = {1 : 5};
Physical Curve("bottom") = {1, 5}; Physical Curve("top") = {4, 8};
Physical Curve("sides") = {9, 14, 11, 13, 16};
