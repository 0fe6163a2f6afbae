// A block below y = 0 beside the axis x = 0 whose cells are fine below the origin and grow away from it.
DefineConstant[
  width = 15, height = 15,
  fine = 1.2,                // extent of the fine patch
  n = 20,                    // its cells along each side
  grow = 1.25                // ratio of the sizes of neighbouring cells outside
];
m = Ceil(Log(1 + (width - fine) * (grow - 1) * n / fine) / Log(grow));
x[] = {0, fine, width};
y[] = {0, -fine, -height};
cells[] = {n, m};
For j In {0 : 2}
  For i In {0 : 2}
    Point(10 * j + i + 1) = {x[i], y[j], 0};
  EndFor
EndFor
For j In {0 : 2}
  For i In {0 : 1}
    Line(100 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 2}; // along x
    Line(200 + 10 * j + i) = {10 * i + j + 1, 10 * i + j + 11}; // down
    Transfinite Curve {100 + 10 * j + i, 200 + 10 * j + i} = cells[i] + 1 Using Progression i == 0 ? 1 : grow;
  EndFor
EndFor
block[] = {};
For j In {0 : 1}
  For i In {0 : 1}
    Curve Loop(300 + 10 * j + i) = {200 + 10 * i + j, 110 + 10 * j + i, -(210 + 10 * i + j), -(100 + 10 * j + i)};
    Plane Surface(300 + 10 * j + i) = {300 + 10 * j + i};
    block[] += {300 + 10 * j + i};
  EndFor
EndFor
Transfinite Surface {block[]};
Recombine Surface {block[]};
Physical Surface("block") = {block[]};
Physical Curve("top") = {100, 101};
Physical Curve("axis") = {200, 201};
Physical Curve("bottom") = {120, 121};
Physical Curve("side") = {220, 221};
