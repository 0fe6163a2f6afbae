// A brake pad on a plate that is drawn under it: pad [5, 15] x [0, 2], plate [0, length] x [-depth, 0], thin cells below the
// surface, where the heat is.
DefineConstant[
  length = 70, depth = 4,
  h = 0.5,      // along the surface
  layers = 16, grading = 1.2 // across the plate, from the surface down
];
Point(1) = {0, -depth, 0}; Point(2) = {length, -depth, 0}; Point(3) = {length, 0, 0}; Point(4) = {0, 0, 0};
Line(1) = {1, 2}; Line(2) = {3, 2}; Line(3) = {3, 4}; Line(4) = {4, 1};
Curve Loop(1) = {1, -2, 3, 4}; Plane Surface(1) = {1};
Transfinite Curve {1, 3} = length / h + 1;
Transfinite Curve {2, 4} = layers + 1 Using Progression grading;
Transfinite Surface {1}; Recombine Surface {1};
Point(11) = {5, 0, 0}; Point(12) = {15, 0, 0}; Point(13) = {15, 2, 0}; Point(14) = {5, 2, 0};
Line(11) = {11, 12}; Line(12) = {12, 13}; Line(13) = {13, 14}; Line(14) = {11, 14};
Curve Loop(11) = {11, 12, 13, -14}; Plane Surface(11) = {11};
Transfinite Curve {11, 13} = 10 / h + 1;
Transfinite Curve {12, 14} = layers + 1 Using Progression grading;
Transfinite Surface {11}; Recombine Surface {11};
Physical Surface("plate") = {1}; Physical Curve("plate_bottom") = {1}; Physical Curve("plate_top") = {3};
Physical Surface("pad") = {11}; Physical Curve("pad_bottom") = {11}; Physical Curve("pad_top") = {13};
