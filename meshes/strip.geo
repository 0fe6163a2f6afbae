// A long strip for plane waves along x: square cells unless n_width says otherwise.
DefineConstant[
  length = 1, width = 0.02,
  n = 200,                                 // cells along the strip
  n_width = Ceil(n * width / length - 0.01)
];
Point(1) = {0, 0, 0};
Point(2) = {length, 0, 0};
Point(3) = {length, width, 0};
Point(4) = {0, width, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Transfinite Curve {1, 3} = n + 1;
Transfinite Curve {2, 4} = n_width + 1;
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
Transfinite Surface {1};
Recombine Surface {1};
Physical Surface("strip") = {1};
Physical Curve("left") = {4};
Physical Curve("right") = {2};
Physical Curve("sides") = {1, 3};
