// Upper half of a compact specimen (ASTM E647), x from the line of the load, the crack on y = 0. Regions "strip", fine
// and where the crack grows, and "arm"; curves "pin" (upper half of the hole), "ligament"; point "back".
DefineConstant[
  W = 50,        // load line to back face
  a = 20,        // crack at the start
  end = 42,      // of the strip
  h = 0.5,       // cell of the strip
  height = 1,    // of the strip
  coarse = 4     // far from it
];
r = 0.125 * W;
Point(1) = {a - 8 * h, 0, 0, h};
Point(2) = {a, 0, 0, h};
Point(3) = {end, 0, 0, h};
Point(4) = {end, height, 0, h};
Point(5) = {a, height, 0, h};
Point(6) = {a - 8 * h, height, 0, h};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 5};
Line(5) = {5, 6};
Line(6) = {6, 1};
Line(7) = {2, 5};
Curve Loop(1) = {1, 7, 5, 6};
Curve Loop(2) = {2, 3, 4, -7};
Plane Surface(1) = {1};
Plane Surface(2) = {2};
Transfinite Curve {1, 5} = 9;
Transfinite Curve {2, 4} = Round((end - a) / h) + 1;
Transfinite Curve {3, 6, 7} = Round(height / h) + 1;
Transfinite Surface {1, 2};

Point(11) = {-0.25 * W, 0, 0, coarse};
Point(12) = {W, 0, 0, coarse};
Point(13) = {W, 0.6 * W, 0, coarse};
Point(14) = {-0.25 * W, 0.6 * W, 0, coarse};
Point(20) = {0, 0.275 * W, 0, coarse};
Point(21) = {r, 0.275 * W, 0, coarse / 2};
Point(22) = {0, 0.275 * W + r, 0, coarse / 2};
Point(23) = {-r, 0.275 * W, 0, coarse / 2};
Point(24) = {0, 0.275 * W - r, 0, coarse / 2};
Line(11) = {11, 1};
Line(12) = {3, 12};
Line(13) = {12, 13};
Line(14) = {13, 14};
Line(15) = {14, 11};
Circle(21) = {21, 20, 22};
Circle(22) = {22, 20, 23};
Circle(23) = {23, 20, 24};
Circle(24) = {24, 20, 21};
Transfinite Curve {21 : 24} = 13;
Curve Loop(3) = {11, -6, -5, -4, -3, 12, 13, 14, 15};
Curve Loop(4) = {21, 22, 23, 24};
Plane Surface(3) = {3, 4};
Recombine Surface {1, 2, 3};
Physical Surface("strip") = {1, 2};
Physical Surface("arm") = {3};
Physical Curve("pin") = {21, 22};
Physical Curve("ligament") = {2, 12};
Physical Point("back") = {12};
