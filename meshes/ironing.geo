// Shallow ironing: a block with a round lower side above a long foundation. Millimetres. Sizes as in Yastrebov,
// Numerical Methods in Contact Mechanics (2013), and Fischer and Wriggers, CMAME 195 (2006) 5020-5036.
DefineConstant[
  length = 12, height = 4, // of the foundation
  left = 0.2,              // of the block, from the foundation's left end
  width = 1.2,
  gap = 0.2,               // between the block's lowest point and the foundation
  sagitta = 0.3,           // of its round side
  side = 0.9,              // of its straight sides
  n = 12,                  // cells along the block
  n_side = n / 2,
  n_length = 10 * n, n_height = 5 * n / 2, // of the foundation
  grow = 1                 // ratio of neighbouring rows of the foundation
];
Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
Point(3) = {length, height, 0};
Point(4) = {0, height, 0};
For i In {1 : 4}
  Line(i) = {i, 1 + i % 4};
EndFor
Transfinite Curve {1, 3} = n_length + 1;
Transfinite Curve {4} = n_height + 1 Using Progression grow;
Transfinite Curve {-2} = n_height + 1 Using Progression grow;
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};

low = height + gap;
radius = (width^2 / 4 + sagitta^2) / (2 * sagitta);
Point(11) = {left, low + sagitta, 0};
Point(12) = {left + width, low + sagitta, 0};
Point(13) = {left + width, low + sagitta + side, 0};
Point(14) = {left, low + sagitta + side, 0};
Point(15) = {left + width / 2, low + radius, 0};
Circle(11) = {11, 15, 12};
Line(12) = {12, 13};
Line(13) = {13, 14};
Line(14) = {14, 11};
Transfinite Curve {11, 13} = n + 1;
Transfinite Curve {12, 14} = n_side + 1;
Curve Loop(11) = {11 : 14};
Plane Surface(11) = {11};
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("foundation") = {1};
Physical Curve("foundation_bottom") = {1};
Physical Curve("foundation_top") = {3};
Physical Surface("block") = {11};
Physical Curve("block_round") = {11};
Physical Curve("block_bottom") = {11, 12, 14};
Physical Curve("block_top") = {13};
