// A round body on a slab: a disc of triangles, fine along its side, whose lowest point stands a gap above the middle of
// the upper side of a slab of quadrilaterals.
DefineConstant[
  radius = 1,
  gap = 0,
  n = 96,                 // cells along the side of the disc
  inner = radius / 4,     // size of the cells in its middle
  length = 6, height = 1, // of the slab
  n_slab = 60, n_height = Ceil(n_slab * height / length),
  start = length / 2      // of the disc, from the left end of the slab
];
x = start; y = height + gap + radius;
Point(1) = {x, y, 0, inner};
For i In {0 : 3}
  Point(2 + i) = {x + radius * Sin(i * Pi / 2), y - radius * Cos(i * Pi / 2), 0};
EndFor
For i In {0 : 3}
  Circle(1 + i) = {2 + i, 1, 2 + (i + 1) % 4};
EndFor
Transfinite Curve {1 : 4} = n / 4 + 1;
Curve Loop(1) = {1 : 4};
Plane Surface(1) = {1};
Point{1} In Surface{1};
Physical Surface("disc") = {1};
Physical Curve("disc_side") = {1 : 4};

Point(11) = {0, 0, 0};
Point(12) = {length, 0, 0};
Point(13) = {length, height, 0};
Point(14) = {0, height, 0};
For i In {0 : 3}
  Line(11 + i) = {11 + i, 11 + (i + 1) % 4};
EndFor
Transfinite Curve {11, 13} = n_slab + 1;
Transfinite Curve {12, 14} = n_height + 1;
Curve Loop(2) = {11 : 14};
Plane Surface(2) = {2};
Transfinite Surface {2};
Recombine Surface {2};
Physical Surface("slab") = {2};
Physical Curve("slab_bottom") = {11};
Physical Curve("slab_top") = {13};
Physical Curve("slab_ends") = {12, 14};
