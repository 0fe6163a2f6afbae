// Half of a cylinder that is pressed into a block, x >= 0: a quarter of a disc with its lowest point at the origin and
// below it a rectangle. Both have a fine patch at the origin; the cells grow away from it.
DefineConstant[
  radius = 50,
  block_width = 100, block_height = 200, // width of the half
  patch = 9,             // width and depth of the fine patches
  n = 20,                // cells along the patch of the block
  n_cylinder = 4 * n / 5, // and along that of the cylinder
  simplices = 0,         // 1: triangles
  grow = 1.25^(20 / n)   // largest ratio of the sizes of neighbouring cells outside
];
Macro Body
  // The patch p[0] p[1] p[2] p[3] (anticlockwise, p[0] at the origin) in the corner of p[0] p[4] p[5] p[6]: a strip of
  // cells along its outer sides.
  along = newl; // p[0] p[1]
  If (disc)
    Circle(along) = {p[0], middle, p[1]};
    Circle(along + 4) = {p[1], middle, p[4]};
  Else
    Line(along) = {p[0], p[1]};
    Line(along + 4) = {p[1], p[4]};
  EndIf
  Line(along + 1) = {p[1], p[2]};
  Line(along + 2) = {p[2], p[3]};
  Line(along + 3) = {p[3], p[0]};
  Line(along + 5) = {p[4], p[5]};
  Line(along + 6) = {p[2], p[5]};
  Line(along + 7) = {p[5], p[6]};
  Line(along + 8) = {p[3], p[6]};
  Transfinite Curve {along, along + 2, along + 7} = m + 1;
  Transfinite Curve {along + 1, along + 3, along + 5} = m + 1;
  // Cells that grow from the patch's size to the outer side.
  ratio = grow;
  k = Ceil(Log(1 + way * (ratio - 1) * m / patch) / Log(ratio));
  Transfinite Curve {along + 4, along + 6, along + 8} = k + 1 Using Progression ratio;
  s = news;
  Curve Loop(s) = {along, along + 1, along + 2, along + 3};
  Plane Surface(s) = {s};
  Curve Loop(s + 1) = {along + 4, along + 5, -(along + 6), -(along + 1)};
  Plane Surface(s + 1) = {s + 1};
  Curve Loop(s + 2) = {along + 6, along + 7, -(along + 8), -(along + 2)};
  Plane Surface(s + 2) = {s + 2};
  Transfinite Surface {s, s + 1, s + 2};
  If (simplices == 0)
    Recombine Surface {s, s + 1, s + 2};
  EndIf
Return

disc = 0; m = n; way = block_height - patch;
p[] = {1, 2, 3, 4, 5, 6, 7};
Point(1) = {0, 0, 0};
Point(2) = {patch, 0, 0};
Point(3) = {patch, -patch, 0};
Point(4) = {0, -patch, 0};
Point(5) = {block_width, 0, 0};
Point(6) = {block_width, -block_height, 0};
Point(7) = {0, -block_height, 0};
Call Body;
Physical Surface("block") = {s, s + 1, s + 2};
Physical Curve("block_face") = {along};
Physical Curve("block_bottom") = {along + 7};
Physical Curve("block_middle") = {along + 3, along + 8};

disc = 1; m = n_cylinder; way = radius - patch;
p[] = {11, 12, 13, 14, 15, 16, 17};
rise = radius - Sqrt(radius^2 - patch^2);
Point(11) = {0, 0, 0};
Point(12) = {patch, rise, 0};
Point(13) = {patch, patch, 0};
Point(14) = {0, patch, 0};
Point(15) = {radius, radius, 0};
Point(16) = {radius / 2, radius, 0};
Point(17) = {0, radius, 0};
middle = 17;
Call Body;
Physical Surface("cylinder") = {s, s + 1, s + 2};
Physical Curve("cylinder_face") = {along};
Physical Curve("cylinder_top") = {along + 5, along + 7};
Physical Curve("cylinder_middle") = {along + 3, along + 8};
