// Half of a flat punch on a wide block, x >= 0: a square punch above the corner of a rectangle whose cells are fine below
// the punch and grow away from it.
DefineConstant[
  a = 10,                        // half width of the punch
  width = 200, height = 200,     // of the half block
  n = 20,                        // cells of the block below the half punch
  n_punch = 3 * n / 4,           // and of the half punch
  grow = 1.2^(20 / n)            // ratio of the sizes of neighbouring cells outside
];
fine = 1.5 * a; // extent of the fine patch
m = 1.5 * n;
k = Ceil(Log(1 + (width - fine) * (grow - 1) * n / a) / Log(grow));
l = Ceil(Log(1 + (height - fine) * (grow - 1) * n / a) / Log(grow));
x[] = {0, fine, width};
y[] = {0, -fine, -height};
columns[] = {m, k};
rows[] = {m, l};
block[] = {};
For j In {0 : 2}
  For i In {0 : 2}
    Point(10 * j + i + 1) = {x[i], y[j], 0};
  EndFor
EndFor
For j In {0 : 2}
  For i In {0 : 1}
    Line(100 + 10 * j + i) = {10 * j + i + 1, 10 * j + i + 2}; // along x
    Line(200 + 10 * j + i) = {10 * i + j + 1, 10 * i + j + 11}; // down
    Transfinite Curve {100 + 10 * j + i} = columns[i] + 1 Using Progression i == 0 ? 1 : grow;
    Transfinite Curve {200 + 10 * j + i} = rows[i] + 1 Using Progression i == 0 ? 1 : grow;
  EndFor
EndFor
For j In {0 : 1}
  For i In {0 : 1}
    Curve Loop(300 + 10 * j + i) = {200 + 10 * i + j, 110 + 10 * j + i, -(210 + 10 * i + j), -(100 + 10 * j + i)};
    Plane Surface(300 + 10 * j + i) = {300 + 10 * j + i};
    block[] += {300 + 10 * j + i};
  EndFor
EndFor
Point(51) = {0, 0, 0};
Point(52) = {a, 0, 0};
Point(53) = {a, a, 0};
Point(54) = {0, a, 0};
For i In {1 : 4}
  Line(50 + i) = {50 + i, 51 + i % 4};
EndFor
Transfinite Curve {51 : 54} = n_punch + 1;
Curve Loop(51) = {51 : 54};
Plane Surface(51) = {51};
Transfinite Surface "*";
Recombine Surface "*";
Physical Surface("block") = block[];
Physical Curve("block_top") = {100}; // the fine part
Physical Curve("block_rest") = {120, 121, 220, 221};
Physical Curve("block_middle") = {200, 201};
Physical Surface("punch") = {51};
Physical Curve("punch_bottom") = {51};
Physical Curve("punch_top") = {53};
Physical Curve("punch_middle") = {54};
